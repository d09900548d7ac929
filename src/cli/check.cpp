#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/progress.h"
#include "cli/commands.h"
#include "logs/check.h"
#include "logs/salvage.h"

namespace wheel_twin::cli {
namespace {

struct Options {
  std::vector<std::string> paths;
  bool salvage = false;
  std::string json;
};

bool is_experiment(const std::string& path) {
  return std::filesystem::is_directory(path) || std::filesystem::path(path).extension() == ".yaml";
}

/// The bag to check instead: the rebuilt one where `path` was damaged.
std::string salvaged(const std::string& path) {
  const logs::Salvage salvage = logs::salvage_bag(path);
  const logs::ScanSummary& summary = salvage.summary;
  if (salvage.output.empty()) {
    fmt::print("{}: intact, {} messages: nothing to salvage\n", path, summary.messages);
    return path;
  }
  fmt::print(
      "{}: salvaged to {}: {} messages of {} topics; {} damaged places, {} of {} chunks lost, {} bytes "
      "passed over\n",
      path, salvage.output, summary.messages, salvage.written.size(), summary.damage_count,
      summary.lost_chunks, summary.chunks, summary.skipped_bytes);
  for (const auto& [topic, count] : salvage.written) fmt::print("  {:<24} {:>7} messages\n", topic, count);
  for (const logs::BagDamage& damage : summary.damage)
    fmt::print("  byte {}: {}\n", damage.offset, damage.text);
  if (salvage.time_zero > 0)
    fmt::print("  {} messages recorded at time 0 have the time of the message before\n", salvage.time_zero);
  return salvage.output;
}

void check(const Options& options) {
  std::vector<logs::CheckReport> reports;
  Progress progress("checking", static_cast<double>(options.paths.size()));
  for (std::size_t i = 0; i < options.paths.size(); ++i) {
    const std::string& path = options.paths[i];
    const std::size_t before = reports.size();
    if (is_experiment(path)) {
      if (options.salvage) throw Error(fmt::format("{}: --salvage takes bags, not an experiment", path));
      auto more = logs::check_experiment(path);
      reports.insert(reports.end(), more.begin(), more.end());
    } else {
      reports.push_back(logs::check_bag(options.salvage ? salvaged(path) : path));
    }
    progress.update(static_cast<double>(i + 1));
    for (std::size_t k = before; k < reports.size(); ++k) fmt::print("{}", logs::to_text(reports[k]));
  }
  if (!options.json.empty()) write_file(options.json, logs::to_json(reports));
  std::vector<std::string> unfit;
  for (const logs::CheckReport& report : reports)
    if (!report.fit()) unfit.push_back(report.file);
  if (unfit.empty()) return;
  throw Error(fmt::format("{}: not fit for use{}", unfit.front(),
                          unfit.size() == 1 ? "" : fmt::format(", nor are {} more", unfit.size() - 1)));
}

}  // namespace

void add_check(CLI::App& app) {
  auto* command =
      app.add_subcommand("check", "Says whether rig logs are fit for use, and what is wrong with them.");
  command->footer(
      "Example: twin check run_00.bag run_01.bag --json check.json\n"
      "         twin check practice_01\n"
      "         twin check --salvage run_02.bag.active\n"
      "Errors make a log unfit (exit 1); warnings do not. doc/importing_logs.md lists every rule.");
  auto options = std::make_shared<Options>();
  command->add_option("logs", options->paths, "Bags, experiment directories or experiment.yaml files")
      ->required();
  command->add_flag("--salvage", options->salvage,
                    "Rebuild a damaged bag beside it (NAME.salvaged.bag) and check the new one");
  command->add_option("--json", options->json, "Also write the findings to this file");
  command->callback([options] { check(*options); });
}

}  // namespace wheel_twin::cli
