#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "base/atomic_file.h"
#include "cli/commands.h"
#include "logs/experiment.h"
#include "twin/diagnosis_report.h"
#include "twin/evaluation.h"

namespace wheel_twin::cli {

void add_diagnose(CLI::App& app) {
  struct Options {
    std::string experiment, out;
    twin::DiagnosisOptions diagnosis;
  };
  auto* command = app.add_subcommand(
      "diagnose", "Closes the loop: what the twin lacks of a rig's logs, traced to an effect and added.");
  command->footer(
      "Example: twin diagnose my_experiment --out out/diagnosis\nWrites index.html, diagnosis.json, "
      "revised_twin.yaml and errors.csv.");
  auto options = std::make_shared<Options>();
  command->add_option("experiment", options->experiment, "Directory with experiment.yaml, or that file")
      ->required();
  command->add_option("--out", options->out, "Directory for the report")->required();
  command->add_option("--threads", options->diagnosis.threads, "Threads, 1 to 64")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->callback([options] {
    const twin::Diagnosis diagnosis =
        twin::diagnose(logs::read_experiment(options->experiment), options->diagnosis);
    twin::write_diagnosis(diagnosis, options->out);
    fmt::print("{}: {}\n{}\n", diagnosis.experiment, diagnosis.verdict, diagnosis.evidence);
    for (const twin::Check& check : diagnosis.checks)
      fmt::print("Check for {}: {}\n", check.effect, check.what);
    for (const auto& [channel, e] : diagnosis.error)
      fmt::print("{:<17} RMSE before {:.3g}, after {:.3g}, noise floor {:.3g} {}\n", twin::name_of(channel),
                 twin::shown_factor(channel) * e.before, twin::shown_factor(channel) * e.after,
                 twin::shown_factor(channel) * e.noise_floor, twin::shown_unit_of(channel));
  });
}

void add_evaluate(CLI::App& app) {
  struct Options {
    std::string twin, experiment, out;
  };
  auto* command = app.add_subcommand(
      "evaluate", "A twin file on an experiment it has not seen: errors only, nothing is fitted.");
  command->footer(
      "Example: twin evaluate out/diagnosis/revised_twin.yaml other_days --out out/evaluation\nWrites "
      "evaluation.json.");
  auto options = std::make_shared<Options>();
  command->add_option("twin", options->twin, "Twin file (revised_twin.yaml)")->required();
  command->add_option("experiment", options->experiment, "Directory with experiment.yaml, or that file")
      ->required();
  command->add_option("--out", options->out, "Directory for evaluation.json")->required();
  command->callback([options] {
    const std::string json =
        twin::evaluate(twin::read_twin(options->twin), logs::read_experiment(options->experiment));
    std::filesystem::create_directories(options->out);
    write_file((std::filesystem::path(options->out) / "evaluation.json").string(), json);
    fmt::print("{}/evaluation.json written\n", options->out);
  });
}

}  // namespace wheel_twin::cli
