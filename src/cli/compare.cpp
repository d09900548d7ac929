#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/config_path.h"
#include "base/error.h"
#include "cli/commands.h"
#include "twin/compare.h"

namespace wheel_twin::cli {
namespace {

struct Options {
  std::string experiment;
  std::string out;
  std::string rig;
};

void compare(const Options& options) {
  std::optional<rig::RigSettings> rig;
  if (!options.rig.empty()) rig = rig::read_rig(yaml::parse_file(find_config("rigs", options.rig)));
  const auto comparison = twin::compare_experiment(logs::read_experiment(options.experiment), {}, rig);
  twin::write_comparison(comparison, options.out);
  const auto any = [](const logs::Run&) { return true; };
  for (const twin::Channel channel : twin::all_channels) {
    const auto error = twin::error_of(comparison.runs, channel, any);
    if (!error) continue;
    const double factor = twin::shown_factor(channel);
    fmt::print("{:<17} RMSE {:.3g} {} over {} runs", twin::name_of(channel), factor * error->rmse,
               twin::shown_unit_of(channel), error->runs);
    if (const auto scatter = twin::repeat_scatter(comparison.runs, channel, any))
      fmt::print(", repeated runs scatter by {:.2g} {}", factor * scatter->std, twin::shown_unit_of(channel));
    fmt::print("\n");
  }
  const auto failed = std::count_if(comparison.runs.begin(), comparison.runs.end(),
                                    [](const twin::RunComparison& run) { return !run.failure.empty(); });
  if (failed > 0)
    fmt::print("{} of {} runs have no prediction: see {}/index.html\n", failed, comparison.runs.size(),
               options.out);
  if (failed == static_cast<std::ptrdiff_t>(comparison.runs.size()))
    throw Error(fmt::format("{}: the twin has no prediction for any run; the first: {}", options.experiment,
                            comparison.runs.empty() ? "there are none" : comparison.runs.front().failure));
}

}  // namespace

void add_compare(CLI::App& app) {
  auto* command = app.add_subcommand(
      "compare",
      "An experiment beside the twin, run by run: residuals, plots, metrics. Fits no soil to runs.");
  command->footer(
      "Example: twin compare out/cmu/smooth --out out/compare\nWrites index.html, metrics.json and "
      "residuals.csv.");
  auto options = std::make_shared<Options>();
  command->add_option("experiment", options->experiment, "Directory with experiment.yaml, or that file")
      ->required();
  command->add_option("--out", options->out, "Directory for the report")->required();
  command->add_option(
      "--rig", options->rig,
      "Rig that was driven, name in config/rigs or a file (default: mount of the sensor from the "
      "reference runs)");
  command->callback([options] { compare(*options); });
}

}  // namespace wheel_twin::cli
