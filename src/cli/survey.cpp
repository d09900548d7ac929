#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "base/atomic_file.h"
#include "cli/commands.h"
#include "logs/experiment.h"
#include "twin/log_survey.h"
#include "twin/page.h"

namespace wheel_twin::cli {

void add_survey(CLI::App& app) {
  struct Options {
    std::string experiment, out;
  };
  auto* command = app.add_subcommand(
      "survey",
      "What logs carry of sensors, rig, wheel and soil, read off without a twin; also what is small.");
  command->footer("Example: twin survey out/cmu/smooth --out out/survey\nWrites survey.json and index.html.");
  auto options = std::make_shared<Options>();
  command->add_option("experiment", options->experiment, "Directory with experiment.yaml, or that file")
      ->required();
  command->add_option("--out", options->out, "Directory for the report")->required();
  command->callback([options] {
    const logs::Experiment experiment = logs::read_experiment(options->experiment);
    const auto items = twin::survey_logs(experiment);
    std::filesystem::create_directories(options->out);
    const auto path = [&](const char* name) { return (std::filesystem::path(options->out) / name).string(); };
    write_file(path("survey.json"), twin::survey_json(experiment.name, items));
    write_file(path("index.html"),
               twin::page::document("Survey of " + experiment.name,
                                    twin::page::heading("Survey of " + experiment.name, experiment.source) +
                                        twin::survey_html(items)));
    for (const twin::SurveyItem& item : items)
      if (std::isfinite(item.value))
        fmt::print("{} {}: {:.3g} +- {:.2g} {} ({})\n", item.found ? "*" : " ", item.what, item.value,
                   item.error, item.unit, item.evidence);
  });
}

}  // namespace wheel_twin::cli
