#include "twin/evaluation.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "twin/fluctuation.h"
#include "twin/run_grid.h"

namespace wheel_twin::twin {
namespace {

using Json = nlohmann::ordered_json;

struct Sum {
  double squares = 0.0;
  std::size_t runs = 0;
};

struct RunChannel {
  double measured = 0.0, twin = 0.0, error = 0.0;
};

/// Means and error of every channel that the run has.
std::map<Channel, RunChannel> channels_of(const RunGrid& grid, const Predicted& predicted) {
  std::map<Channel, RunChannel> result;
  for (const Channel channel : all_channels) {
    const auto c = static_cast<Eigen::Index>(index_of(channel));
    RunChannel sum;
    int count = 0;
    for (int i = 0; i < grid.bins(); ++i) {
      if (!grid.moving[static_cast<std::size_t>(i)] || !std::isfinite(grid.measured(c, i))) continue;
      sum.measured += grid.measured(c, i);
      sum.twin += predicted(c, i);
      sum.error += std::pow(grid.measured(c, i) - predicted(c, i), 2);
      ++count;
    }
    if (count > 0) result[channel] = {sum.measured / count, sum.twin / count, std::sqrt(sum.error / count)};
  }
  for (const WindowMean& window : grid.windows) {
    const double twin = window_mean(predicted, grid, window);
    if (std::isfinite(twin)) result[window.channel] = {window.mean, twin, std::abs(window.mean - twin)};
  }
  return result;
}

}  // namespace

std::string evaluate(const TwinConfig& twin, const logs::Experiment& experiment) {
  std::map<Channel, Sum> sums;
  Json runs = Json::array();
  std::string first_failure;
  for (const RunGrid& grid : read_runs(experiment)) {
    Json entry = {{"run", grid.name},
                  {"slip", grid.declared.slip},
                  {"load", grid.declared.load},
                  {"steering_angle", grid.declared.steering_angle}};
    if (!grid.declared.group.empty()) entry["group"] = grid.declared.group;
    try {
      for (const auto& [channel, value] : channels_of(grid, slow_course(twin, grid))) {
        entry[std::string(name_of(channel))] = {{"measured", value.measured}, {"twin", value.twin}};
        sums[channel].squares += value.error * value.error;
        ++sums[channel].runs;
      }
    } catch (const Error& error) {
      entry["failure"] = error.what();
      if (first_failure.empty()) first_failure = fmt::format("{}: {}", grid.name, error.what());
    }
    runs.push_back(entry);
  }
  if (sums.empty())
    throw Error(fmt::format("{}: no run can be evaluated; {}", experiment.name, first_failure));
  Json json = {
      {"schema", 1}, {"experiment", experiment.name}, {"twin", twin.name}, {"error", Json::object()}};
  for (const auto& [channel, sum] : sums)
    json["error"][std::string(name_of(channel))] = {
        {"unit", unit_of(channel)},
        {"rmse", std::sqrt(sum.squares / static_cast<double>(sum.runs))},
        {"runs", sum.runs}};
  json["runs"] = runs;
  return json.dump(1) + "\n";
}

}  // namespace wheel_twin::twin
