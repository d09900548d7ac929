#include <fmt/format.h>

#include <memory>

#include "cli/commands.h"
#include "logs/cmu_testbed.h"

namespace wheel_twin::cli {
namespace {

struct Options {
  std::string format;
  std::string directory;
  std::string out;
};

void import_cmu_testbed(const Options& options) {
  const auto summary = logs::cmu::import(options.directory, options.out);
  for (const auto& remark : summary.remarks) fmt::print("note: {}\n", remark);
  for (const auto& experiment : summary.experiments)
    fmt::print("{}: {} runs ({} with a bag), {} pressings\n", experiment.directory, experiment.runs,
               experiment.bags, experiment.pressings);
}

}  // namespace

void add_import(CLI::App& app) {
  auto* command = app.add_subcommand("import", "Foreign logs to experiments in this project's form.");
  command->footer("Example: twin import cmu_testbed data/cmu_testbed_sample --out out/cmu");
  auto options = std::make_shared<Options>();
  command->add_option("format", options->format, "Format of the logs: cmu_testbed")
      ->required()
      ->check(CLI::IsMember({"cmu_testbed"}));
  command->add_option("directory", options->directory, "Where the logs lie")->required();
  command->add_option("--out", options->out, "Directory for the experiments")->required();
  command->callback([options] { import_cmu_testbed(*options); });
}

}  // namespace wheel_twin::cli
