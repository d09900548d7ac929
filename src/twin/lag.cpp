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
constexpr double quick_window = 1.5;  // s, the same for what is compared run by run
constexpr double least_correlation = 0.4;
constexpr double side_lobe =
    level_window / 4.0;  // s; taking the level off makes peaks of the other sign from there on
constexpr double least_far_correlation = 0.6;

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

/// Correlation of `follower` with `reference` at lags from -reach to reach steps.
Eigen::VectorXd correlations(const Eigen::Ref<const Eigen::VectorXd>& reference,
                             const Eigen::Ref<const Eigen::VectorXd>& follower, int reach) {
  const auto n = static_cast<int>(reference.size());
  Eigen::VectorXd result(2 * reach + 1);
  for (int lag = -reach; lag <= reach; ++lag) {
    const int from = std::max(0, -lag), count = n - std::abs(lag);
    const auto a = reference.segment(from, count), b = follower.segment(from + lag, count);
    const double scale = a.norm() * b.norm();
    result[lag + reach] = scale > 0.0 ? a.dot(b) / scale : 0.0;
  }
  return result;
}

std::optional<Lag> peak(const Eigen::VectorXd& reference, const Eigen::VectorXd& follower, double step) {
  const int reach = static_cast<int>(longest_lag / step);
  if (reference.size() < 4 * reach) return std::nullopt;
  const Eigen::VectorXd correlation = correlations(reference, follower, reach);
  Eigen::Index i = 0;
  const double best = correlation.cwiseAbs().maxCoeff(&i);
  if (best < least_correlation || i == 0 || i + 1 == correlation.size()) return std::nullopt;
  const double before = correlation[i - 1], after = correlation[i + 1];
  const double curvature = before - 2.0 * correlation[i] + after;
  const double shift = curvature != 0.0 ? 0.5 * (before - after) / curvature : 0.0;
  const double lag = (static_cast<double>(i) - reach + std::clamp(shift, -0.5, 0.5)) * step;
  if (std::abs(lag) > side_lobe && best < least_far_correlation) return std::nullopt;
  return Lag{lag, best};
}

/// Mean time from sample to sample, s; 0 for less than two.
double spacing(const std::vector<double>& time) {
  return time.size() < 2 ? 0.0 : (time.back() - time.front()) / static_cast<double>(time.size() - 1);
}

/// Displacement, pitch torque and drawbar pull on common ticks, level removed.
struct Fluctuations {
  Eigen::VectorXd hub, torque, pull;
};

struct Span {
  double start = 0.0, end = 0.0;  // s
};

/// While both sensors log.
Span common_span(const run_log::RunLog& log) {
  return {std::max(log.ft.time.front(), log.draw_wire.time.front()),
          std::min(log.ft.time.back(), log.draw_wire.time.back())};
}

/// While wheel or carriage moves at a good share of its largest speed, the wheel out of its print; empty when
/// neither does.
Span moving_span(const run_log::JointSeries& joints) {
  constexpr double share = 0.5;
  constexpr double leaving = 4.0;  // s
  const auto fastest = [](const std::vector<double>& rates) {
    double most = 0.0;
    for (const double rate : rates) most = std::max(most, std::abs(rate));
    return most;
  };
  const double wheel = fastest(joints.wheel_rate), carriage = fastest(joints.carriage_velocity);
  Span span;
  for (std::size_t i = 0; i < joints.time.size(); ++i) {
    const bool moves = (wheel > 0.0 && std::abs(joints.wheel_rate[i]) > share * wheel) ||
                       (carriage > 0.0 && std::abs(joints.carriage_velocity[i]) > share * carriage);
    if (!moves) continue;
    if (span.end == 0.0) span.start = joints.time[i];
    span.end = joints.time[i];
  }
  span.start += leaving;
  return span;
}

std::optional<Fluctuations> fluctuations_of(const run_log::RunLog& log, const Span& span, double step,
                                            double window) {
  const auto& ft = log.ft.time;
  const auto& wire = log.draw_wire.time;
  Fluctuations f;
  const int n = static_cast<int>((span.end - span.start) / step);
  if (n < 100) return std::nullopt;
  const int half = static_cast<int>(0.5 * window / step);
  const auto fluctuation = [&](const std::vector<double>& time, const auto& value) {
    return level_free(resampled(time, value, span.start, step, n), half);
  };
  f.hub = fluctuation(wire, [&](std::size_t i) { return log.draw_wire.value[i]; });
  f.torque = fluctuation(ft, [&](std::size_t i) { return log.ft.torque[i].y(); });
  f.pull = fluctuation(ft, [&](std::size_t i) { return log.ft.force[i].x(); });
  return f;
}

}  // namespace

std::optional<Lag> draw_wire_lag(const run_log::RunLog& log) {
  if (log.ft.time.size() < 50 || log.draw_wire.time.size() < 50) return std::nullopt;
  const double step = std::max({0.01, spacing(log.ft.time), spacing(log.draw_wire.time)});
  const std::optional<Fluctuations> f = fluctuations_of(log, common_span(log), step, level_window);
  if (!f) return std::nullopt;
  const auto a = peak(f->torque, f->hub, step), b = peak(f->pull, f->hub, step);
  if (!a || !b) return a ? a : b;
  return a->correlation >= b->correlation ? a : b;
}

std::optional<LagCurves> lag_curves(const run_log::RunLog& log) {
  constexpr int stretches = 4;
  if (log.ft.time.size() < 50 || log.draw_wire.time.size() < 50) return std::nullopt;
  const Span both = common_span(log), moving = moving_span(log.joints);
  const std::optional<Fluctuations> f =
      fluctuations_of(log, {std::max(both.start, moving.start), std::min(both.end, moving.end)},
                      LagCurves::step, quick_window);
  if (!f) return std::nullopt;
  LagCurves curves;
  const int reach = static_cast<int>(longest_lag / LagCurves::step);
  const auto length = static_cast<int>(f->hub.size()) / stretches;
  if (length < 2 * reach) return std::nullopt;
  for (int k = 0; k < stretches; ++k) {
    const auto part = [&](const Eigen::VectorXd& whole) { return whole.segment(k * length, length); };
    curves.stretches.push_back({correlations(part(f->torque), part(f->hub), reach),
                                correlations(part(f->pull), part(f->hub), reach)});
  }
  return curves;
}

}  // namespace wheel_twin::twin
