#include "twin/evaluation.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/progress.h"
#include "logs/bag_reader.h"
#include "twin/compare.h"
#include "twin/metrics.h"
#include "twin/run_comparison.h"

namespace wheel_twin::twin {
namespace {

using Json = nlohmann::ordered_json;

struct Sum {
  double squares = 0.0;
  std::size_t runs = 0;

  void add(double error) {
    squares += error * error;
    ++runs;
  }
};
using Sums = std::map<Channel, Sum>;

Json json_of(const Sums& sums) {
  Json json = Json::object();
  for (const auto& [channel, sum] : sums)
    json[std::string(name_of(channel))] = {{"unit", unit_of(channel)},
                                           {"rmse", std::sqrt(sum.squares / static_cast<double>(sum.runs))},
                                           {"runs", sum.runs}};
  return json;
}

}  // namespace

std::string evaluate(const TwinConfig& twin, const logs::Experiment& experiment) {
  constexpr double step = 0.1;  // of the twin, s: errors are of slow courses and of means
  TwinConfig model = twin;
  model.rig.steering_limit = 1.5;  // of the contact; the rig that was driven had its own
  Sums all, straight, driving;
  Json runs = Json::array();
  std::string first_failure;
  Progress progress("evaluating", static_cast<double>(experiment.runs.size()));
  for (std::size_t i = 0; i < experiment.runs.size(); ++i) {
    const logs::Run& run = experiment.runs[i];
    std::optional<run_log::RunLog> log;
    if (run.bag) log = logs::read_run_log(experiment.path_of(*run.bag));
    ComparisonOptions options;
    options.step = step;
    const RunComparison compared =
        compare_run(model, run, name_of_run(experiment, i), log ? &*log : nullptr, options);
    Json entry = {{"run", compared.name},
                  {"role", logs::to_string(run.role)},
                  {"slip", run.slip},
                  {"load", compared.load},
                  {"steering_angle", run.steering_angle}};
    if (!run.group.empty()) entry["group"] = run.group;
    bool any = false;
    for (const Channel channel : all_channels) {
      const auto& value = compared.at(channel);
      if (!value || !std::isfinite(value->error)) continue;
      entry[std::string(name_of(channel))] = {
          {"measured", value->mean.measured}, {"twin", value->mean.twin}, {"error", value->error}};
      all[channel].add(value->error);
      if (is_straight(run)) straight[channel].add(value->error);
      if (is_straight(run) && is_driving(run)) driving[channel].add(value->error);
      any = true;
    }
    if (!any) {
      entry["failure"] =
          compared.failure.empty() ? "nothing measured that a twin foretells" : compared.failure;
      if (first_failure.empty())
        first_failure = fmt::format("{}: {}", compared.name, entry["failure"].get<std::string>());
    }
    runs.push_back(entry);
    progress.update(static_cast<double>(i + 1));
  }
  if (all.empty())
    throw Error(fmt::format("{}: no run can be evaluated; {}", experiment.name, first_failure));
  const Json json = {{"schema", 1},
                     {"experiment", experiment.name},
                     {"twin", twin.name},
                     {"error", json_of(all)},
                     {"error_straight", json_of(straight)},
                     {"error_straight_driving", json_of(driving)},
                     {"runs", runs}};
  return json.dump(1) + "\n";
}

}  // namespace wheel_twin::twin
