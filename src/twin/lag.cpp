#include "twin/lag.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace wheel_twin::twin {
namespace {

constexpr double longest_lag = 3.0;   // s
constexpr double level_window = 4.0;  // s
constexpr double least_correlation = 0.4;

/// Linear interpolation on a regular grid.
Eigen::VectorXd resampled(const std::vector<double>& time, const std::function<double(std::size_t)>& value,
                          double start, double step, int n) {
  Eigen::VectorXd result(n);
  std::size_t j = 0;
  for (int i = 0; i < n; ++i) {
    const double t = start + i * step;
    while (j + 2 < time.size() && time[j + 1] < t) ++j;
    const double share = std::clamp((t - time[j]) / (time[j + 1] - time[j]), 0.0, 1.0);
    result[i] = value(j) * (1.0 - share) + value(j + 1) * share;
  }
  return result;
}

/// Less its running mean, clipped at four deviations so that a jump does not rule.
Eigen::VectorXd level_free(const Eigen::VectorXd& x, int half) {
  const auto n = static_cast<int>(x.size());
  Eigen::VectorXd cumulated(n + 1);
  cumulated[0] = 0.0;
  for (int i = 0; i < n; ++i) cumulated[i + 1] = cumulated[i] + x[i];
  Eigen::VectorXd result(n);
  for (int i = 0; i < n; ++i) {
    const int a = std::max(0, i - half), b = std::min(n, i + half + 1);
    result[i] = x[i] - (cumulated[b] - cumulated[a]) / (b - a);
  }
  std::vector<double> magnitude(result.data(), result.data() + n);
  for (double& m : magnitude) m = std::abs(m);
  std::nth_element(magnitude.begin(), magnitude.begin() + n / 2, magnitude.end());
  const double limit = 4.0 * 1.4826 * magnitude[static_cast<std::size_t>(n / 2)];
  return result.cwiseMax(-limit).cwiseMin(limit);
}

std::optional<Lag> peak(const Eigen::VectorXd& reference, const Eigen::VectorXd& follower, double step) {
  const int reach = static_cast<int>(longest_lag / step);
  const auto n = static_cast<int>(reference.size());
  if (n < 4 * reach) return std::nullopt;
  std::vector<double> correlation;
  for (int lag = -reach; lag <= reach; ++lag) {
    const int from = std::max(0, -lag), count = n - std::abs(lag);
    const auto a = reference.segment(from, count), b = follower.segment(from + lag, count);
    const double scale = a.norm() * b.norm();
    correlation.push_back(scale > 0.0 ? a.dot(b) / scale : 0.0);
  }
  const auto best = std::max_element(correlation.begin(), correlation.end(),
                                     [](double a, double b) { return std::abs(a) < std::abs(b); });
  const auto i = best - correlation.begin();
  if (std::abs(*best) < least_correlation || i == 0 ||
      i + 1 == static_cast<std::ptrdiff_t>(correlation.size()))
    return std::nullopt;
  const double before = correlation[static_cast<std::size_t>(i - 1)],
               after = correlation[static_cast<std::size_t>(i + 1)];
  const double curvature = before - 2.0 * *best + after;
  const double shift = curvature != 0.0 ? 0.5 * (before - after) / curvature : 0.0;
  return Lag{(static_cast<double>(i) - reach + std::clamp(shift, -0.5, 0.5)) * step, std::abs(*best)};
}

}  // namespace

std::optional<Lag> draw_wire_lag(const run_log::RunLog& log) {
  const auto& ft = log.ft.time;
  const auto& wire = log.draw_wire.time;
  if (ft.size() < 50 || wire.size() < 50) return std::nullopt;
  const double start = std::max(ft.front(), wire.front()), end = std::min(ft.back(), wire.back());
  const double step = std::max({0.01, (ft.back() - ft.front()) / static_cast<double>(ft.size() - 1),
                                (wire.back() - wire.front()) / static_cast<double>(wire.size() - 1)});
  const int n = static_cast<int>((end - start) / step);
  if (n < 100) return std::nullopt;
  const int half = static_cast<int>(0.5 * level_window / step);
  const Eigen::VectorXd hub =
      level_free(resampled(
                     wire, [&](std::size_t i) { return log.draw_wire.value[i]; }, start, step, n),
                 half);
  const Eigen::VectorXd torque =
      level_free(resampled(
                     ft, [&](std::size_t i) { return log.ft.torque[i].y(); }, start, step, n),
                 half);
  const Eigen::VectorXd pull =
      level_free(resampled(
                     ft, [&](std::size_t i) { return log.ft.force[i].x(); }, start, step, n),
                 half);
  const auto a = peak(torque, hub, step), b = peak(pull, hub, step);
  if (!a || !b) return a ? a : b;
  return a->correlation >= b->correlation ? a : b;
}

}  // namespace wheel_twin::twin
