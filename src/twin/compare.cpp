#include "twin/compare.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/progress.h"
#include "logs/bag_reader.h"

namespace wheel_twin::twin {
namespace {

using nlohmann::ordered_json;

bool any(const logs::Run&) {
  return true;
}

ordered_json json_of(const Estimate& estimate, const char* unit) {
  return {{"value", estimate.value}, {"stderr", estimate.standard_error}, {"unit", unit}};
}

ordered_json json_of(const PlateFit& fit, double width) {
  ordered_json json = {
      {"k_c", json_of(fit.k_c, "N/m^(n+1)")},
      {"k_phi", json_of(fit.k_phi, "N/m^(n+2)")},
      {"n", json_of(fit.n, "1")},
      {"modulus_at_width", {{"width", width}, {"value", fit.modulus(width)}}},
      {"relative_error_of_pressure_at_width", fit.relative_error_at_width},
      {"reference_depth", fit.reference_depth},
      {"between_tests",
       {{"ln_pressure", fit.between_tests_pressure}, {"exponent", fit.between_tests_exponent}}},
      {"within_test_ln_force", fit.within_test}};
  if (fit.compliance) json["rig_compliance"] = json_of(*fit.compliance, "m/N");
  for (const auto& test : fit.tests)
    json["tests"].push_back({{"test", test.name},
                             {"diameter", test.diameter},
                             {"pressure", test.pressure},
                             {"exponent", test.exponent}});
  return json;
}

ordered_json json_of(const rig::MountFit& fit) {
  return {{"arm_x", json_of({fit.mount.arm_x, fit.arm_x_error}, "m")},
          {"arm_z", json_of({fit.mount.arm_z, fit.arm_z_error}, "m")},
          {"drive_torque_share", json_of({fit.mount.drive_torque_share, fit.share_error}, "1")},
          {"residual", {{"value", fit.residual}, {"unit", "N m"}, {"averages", fit.averages}}}};
}

/// From the straight reference runs; none where they lack the channels for it.
std::optional<rig::MountFit> mount_of_references(const logs::Experiment& experiment,
                                                 const rig::MountSettings& prior) {
  std::vector<run_log::RunLog> read;
  for (const logs::Run& run : experiment.runs)
    if (run.role == logs::Role::reference && run.bag && is_straight(run))
      read.push_back(logs::read_run_log(experiment.path_of(*run.bag)));
  std::vector<const run_log::RunLog*> references;
  references.reserve(read.size());
  for (const run_log::RunLog& log : read) references.push_back(&log);
  constexpr std::size_t least_averages = 20;
  rig::MountFit fit = rig::fit_mount(references, prior);
  if (fit.averages < least_averages) return std::nullopt;
  return fit;
}

ordered_json error_json(const std::vector<RunComparison>& runs, const RunFilter& filter) {
  ordered_json json = ordered_json::object();
  for (const Channel channel : all_channels) {
    const auto error = error_of(runs, channel, filter);
    if (!error) continue;
    ordered_json entry = {
        {"unit", unit_of(channel)}, {"rmse", error->rmse}, {"mean", error->mean}, {"runs", error->runs}};
    if (const auto constant = error_of_constant(runs, channel, filter))
      entry["rmse_of_best_constant"] = *constant;
    if (const auto scatter = repeat_scatter(runs, channel, filter))
      entry["repeat_scatter"] = {
          {"std", scatter->std}, {"runs", scatter->runs}, {"conditions", scatter->conditions}};
    json[std::string(name_of(channel))] = entry;
  }
  return json;
}

}  // namespace

std::string name_of_run(const logs::Experiment& experiment, std::size_t index) {
  const logs::Run& run = experiment.runs[index];
  if (run.bag) return *run.bag;
  return fmt::format("{}{}#{}", run.group, run.group.empty() ? "" : " ", index);
}

ExperimentComparison compare_experiment(const logs::Experiment& experiment, const ComparisonOptions& options,
                                        const std::optional<rig::RigSettings>& rig) {
  ExperimentComparison comparison;
  comparison.experiment = experiment;
  comparison.soil = experiment.soil;
  comparison.press_curves = read_press_curves(experiment);
  if (!comparison.press_curves.empty()) {
    try {
      comparison.plate_fit = fit_plates(comparison.press_curves, experiment.wheel.width);
      comparison.soil = soil_of_fit(experiment.soil, *comparison.plate_fit);
    } catch (const Error& error) {
      comparison.plate_note = error.what();
    }
  }
  if (rig) {
    comparison.rig = *rig;
  } else {
    comparison.mount_fit = mount_of_references(experiment, comparison.rig.mount);
    if (comparison.mount_fit) comparison.rig.mount = comparison.mount_fit->mount;
  }
  comparison.rig.steering_limit = 1.5;  // of the contact; the rig that was driven had its own
  TwinConfig model;
  model.wheel = experiment.wheel;
  model.soil = comparison.soil;
  model.rig = comparison.rig;
  Progress progress("comparing", static_cast<double>(experiment.runs.size()));
  for (std::size_t i = 0; i < experiment.runs.size(); ++i) {
    const logs::Run& run = experiment.runs[i];
    std::optional<run_log::RunLog> log;
    if (run.bag) log = logs::read_run_log(experiment.path_of(*run.bag));
    comparison.runs.push_back(
        compare_run(model, run, name_of_run(experiment, i), log ? &*log : nullptr, options));
    progress.update(static_cast<double>(i + 1));
  }
  return comparison;
}

std::string metrics_json(const ExperimentComparison& comparison) {
  const std::vector<RunComparison>& runs = comparison.runs;
  const auto& soil = comparison.soil;
  ordered_json json = {{"schema", 1}, {"experiment", comparison.experiment.name}};
  json["twin"] = {{"wheel", comparison.experiment.wheel.name},
                  {"soil",
                   {{"name", soil.name},
                    {"k_c", soil.k_c},
                    {"k_phi", soil.k_phi},
                    {"n", soil.n},
                    {"c", soil.c},
                    {"phi", soil.phi},
                    {"K", soil.K},
                    {"c1", soil.c1},
                    {"c2", soil.c2},
                    {"gamma", soil.gamma}}},
                  {"soil_from", comparison.plate_fit ? "plate tests and declaration" : "declaration"}};
  json["twin"]["mount_from"] = comparison.mount_fit ? "reference runs" : "rig " + comparison.rig.name;
  if (comparison.mount_fit) json["mount_fit"] = json_of(*comparison.mount_fit);
  if (comparison.plate_fit)
    json["plate_fit"] = json_of(*comparison.plate_fit, comparison.experiment.wheel.width);
  if (!comparison.plate_note.empty()) json["plate_fit_failed"] = comparison.plate_note;
  json["error"] = error_json(runs, any);
  json["error_straight"] = error_json(runs, is_straight);
  json["error_straight_driving"] =
      error_json(runs, [](const logs::Run& run) { return is_straight(run) && is_driving(run); });
  for (const logs::Role role : {logs::Role::reference, logs::Role::measured, logs::Role::held_out}) {
    const ordered_json by_role = error_json(runs, [role](const logs::Run& run) { return run.role == role; });
    if (!by_role.empty()) json["error_by_role"][logs::to_string(role)] = by_role;
  }
  json["runs"] = ordered_json::array();
  for (const RunComparison& run : runs) {
    ordered_json entry = {{"run", run.name},
                          {"role", logs::to_string(run.run.role)},
                          {"slip", run.run.slip},
                          {"load", run.load},
                          {"steering_angle", run.run.steering_angle}};
    if (!run.run.group.empty()) entry["group"] = run.run.group;
    for (const Channel channel : all_channels) {
      const auto& compared = run.at(channel);
      if (!compared) continue;
      entry[std::string(name_of(channel))] = {{"measured", compared->mean.measured},
                                              {"twin", compared->mean.twin},
                                              {compared->from_average ? "error" : "rmse", compared->error}};
    }
    if (!run.failure.empty()) entry["no_prediction"] = run.failure;
    json["runs"].push_back(entry);
  }
  return json.dump(1) + "\n";
}

std::string residuals_csv(const ExperimentComparison& comparison) {
  std::string csv = "run,channel,unit,time_s,measured,twin\n";
  for (const RunComparison& run : comparison.runs)
    for (const Channel channel : all_channels) {
      const auto& compared = run.at(channel);
      if (!compared || !compared->series) continue;
      const SeriesComparison& series = *compared->series;
      const std::size_t stride = std::max<std::size_t>(1, series.time.size() / 500);
      for (std::size_t i = 0; i < series.time.size(); i += stride)
        csv += fmt::format("{},{},{},{:.4f},{:.6g},{:.6g}\n", run.name, name_of(channel), unit_of(channel),
                           series.time[i], series.measured[i], series.twin[i]);
    }
  return csv;
}

void write_comparison(const ExperimentComparison& comparison, const std::string& directory) {
  std::error_code code;
  std::filesystem::create_directories(directory, code);
  if (code) throw Error(fmt::format("{}: cannot be made: {}", directory, code.message()));
  const auto path = [&](const char* name) { return (std::filesystem::path(directory) / name).string(); };
  write_file(path("metrics.json"), metrics_json(comparison));
  write_file(path("residuals.csv"), residuals_csv(comparison));
  write_file(path("index.html"), comparison_page(comparison));
}

}  // namespace wheel_twin::twin
