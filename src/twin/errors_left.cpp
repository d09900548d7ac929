#include "twin/errors_left.h"

#include <algorithm>
#include <cmath>

#include "twin/fluctuation.h"

namespace wheel_twin::twin {
namespace {

/// Deviation of a channel that a perfect twin would still show: fluctuation and what differs between runs.
double floor_of(const ChannelNoise& noise) {
  return std::hypot(noise.deviation, noise.run_offset);
}

double rmse(const std::vector<const RunGrid*>& runs, const std::vector<Predicted>& predicted,
            Eigen::Index channel) {
  double sum = 0.0;
  long count = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Residual residual = residual_of(*runs[r], predicted[r]);
    for (int i = 0; i < runs[r]->bins(); ++i)
      if (runs[r]->moving[static_cast<std::size_t>(i)] && std::isfinite(residual.bins(channel, i))) {
        sum += residual.bins(channel, i) * residual.bins(channel, i);
        ++count;
      }
    for (std::size_t w = 0; w < runs[r]->windows.size(); ++w)
      if (index_of(runs[r]->windows[w].channel) == static_cast<std::size_t>(channel)) {
        sum += residual.windows[w] * residual.windows[w];
        ++count;
      }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : std::nan("");
}

/// Root mean square of the noise floors of the runs, each with as much weight as it has values.
double common_floor(const std::vector<const RunGrid*>& runs, const std::vector<NoiseModel>& noise,
                    Eigen::Index channel) {
  double sum = 0.0, count = 0.0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    double values = 0.0;
    for (int i = 0; i < runs[r]->bins(); ++i)
      if (runs[r]->moving[static_cast<std::size_t>(i)] && std::isfinite(runs[r]->measured(channel, i)))
        values += 1.0;
    for (const WindowMean& window : runs[r]->windows)
      if (index_of(window.channel) == static_cast<std::size_t>(channel)) values += 1.0;
    sum += values * std::pow(floor_of(noise[r][static_cast<std::size_t>(channel)]), 2);
    count += values;
  }
  return std::sqrt(sum / std::max(1.0, count));
}

}  // namespace

Errors errors_of(const std::vector<const RunGrid*>& runs, const TwinConfig& before, const TwinConfig& after,
                 const std::vector<NoiseModel>& noise) {
  std::vector<Predicted> with, without;
  for (const RunGrid* run : runs) {
    without.push_back(slow_course(before, *run));
    with.push_back(slow_course(after, *run));
  }
  Errors errors;
  for (const Channel channel : all_channels) {
    const auto c = static_cast<Eigen::Index>(index_of(channel));
    const double value = rmse(runs, without, c);
    if (std::isfinite(value)) errors[channel] = {value, rmse(runs, with, c), common_floor(runs, noise, c)};
  }
  return errors;
}

Errors with_floors_of(const std::vector<NoiseModel>& noise, const std::vector<const RunGrid*>& runs,
                      Errors errors) {
  for (auto& [channel, error] : errors)
    error.noise_floor = common_floor(runs, noise, static_cast<Eigen::Index>(index_of(channel)));
  return errors;
}

double worst_ratio(const Errors& errors) {
  double worst = 0.0;
  for (const auto& [channel, error] : errors) {
    const bool undisturbed =
        error.before < plainly_wrong * error.noise_floor && error.after < 1.1 * error.before;
    if (!undisturbed) worst = std::max(worst, error.after / error.noise_floor);
  }
  return worst;
}

double added(const Errors& errors) {
  double sum = 0.0;
  for (const auto& [channel, error] : errors)
    sum +=
        (error.after * error.after - error.before * error.before) / (error.noise_floor * error.noise_floor);
  return sum;
}

double least_gone(const Errors& errors) {
  double least = 1.0;
  bool disturbed = false;
  for (const auto& [channel, error] : errors) {
    if (error.before < plainly_wrong * error.noise_floor) continue;
    disturbed = true;
    const double floor = good_enough * error.noise_floor;
    const double left = std::max(0.0, error.after * error.after - floor * floor);
    least = std::min(least, 1.0 - left / (error.before * error.before));
  }
  return disturbed ? least : 0.0;
}

}  // namespace wheel_twin::twin
