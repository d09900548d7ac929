#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/progress.h"
#include "base/yaml.h"
#include "bulk/calibrate.h"
#include "bulk/folder.h"
#include "cli/commands.h"

namespace wheel_twin::cli {
namespace {

struct Options {
  std::string soil;
  std::string measured;
  std::string out;
  bulk::CalibrationSettings settings;
  bulk::TestSettings tests;
};

// Evaluations of a run that was cut short: one line each, after a line that says what they belong to.
std::vector<bulk::Evaluation> read_earlier(const std::string& path, const std::string& header) {
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line)) return {};
  if (line != header)
    throw Error(fmt::format("{}: belongs to another calibration: remove it or choose another folder", path));
  std::vector<bulk::Evaluation> evaluations;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    bulk::Evaluation e;
    std::string text[5];
    for (std::string& word : text)
      if (!(words >> word))
        throw Error(fmt::format("{}: line {} is not complete", path, evaluations.size() + 2));
    e.at = {std::stod(text[0]), std::stod(text[1])};
    for (std::size_t q = 0; q < bulk::quantity_count; ++q) e.value[q] = std::stod(text[2 + q]);
    evaluations.push_back(e);
  }
  return evaluations;
}

void run(const Options& options) {
  const dem::GranularSoil soil = dem::load_granular_soil(options.soil);
  const bulk::Measurements measured = bulk::read_measurements(yaml::parse_file(options.measured));
  bulk::make_folder(options.out);
  const std::string path = options.out + "/progress.txt";
  const std::string header = fmt::format(
      "rate {} travel {} heap {} friction {} {} modulus {} {} seed {} soil {}", options.tests.shear_rate,
      options.tests.travel, options.tests.heap_clumps, options.settings.lowest_friction,
      options.settings.highest_friction, options.settings.lowest_modulus, options.settings.highest_modulus,
      options.settings.seed, std::hash<std::string>{}(soil.fingerprint()));
  Progress progress("calibrate", options.settings.largest_points);
  const bulk::Calibration result =
      bulk::calibrate(measured, options.settings, bulk::bulk_tests(soil, measured, options.tests),
                      read_earlier(path, header), [&](const std::vector<bulk::Evaluation>& evaluations) {
                        std::string text = header + "\n";
                        for (const bulk::Evaluation& e : evaluations)
                          text += fmt::format("{} {} {} {} {}\n", e.at.friction, e.at.shear_modulus,
                                              e.value[0], e.value[1], e.value[2]);
                        write_file(path, text);
                        progress.update(static_cast<double>(evaluations.size()));
                      });
  bulk::write_calibration(options.out, soil, measured, result);
  fmt::print("{}: friction {:.3f}, shear modulus {:.3g} Pa after {} parameter sets. {}\n", options.out,
             result.best.friction, result.best.shear_modulus, result.evaluations.size(), result.undetermined);
}

}  // namespace

void add_calibrate(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "calibrate", "Friction and shear modulus of the grains from measured bulk properties");
  command->add_option("--soil", options->soil, "name in config/soils or a file: clumps and everything else")
      ->required();
  command
      ->add_option("--measured", options->measured,
                   "YAML: cohesion (Pa), friction_angle (rad), angle_of_repose (rad), each {value, stderr}")
      ->required();
  command->add_option("--out", options->out, "folder; a run that was cut short goes on from it")->required();
  command->add_option("--points", options->settings.largest_points, "simulated parameter sets at most")
      ->capture_default_str();
  command->add_option("--rate", options->tests.shear_rate, "of the lower frame, m/s")->capture_default_str();
  command->add_option("--travel", options->tests.travel, "of the lower frame, m")->capture_default_str();
  command->add_option("--heap-clumps", options->tests.heap_clumps, "in the funnel")->capture_default_str();
  command->add_option("--highest-friction", options->settings.highest_friction, "highest friction searched")
      ->capture_default_str();
  command->add_option("--threads", options->tests.threads, "threads")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command->footer(
      "Example: twin calibrate --soil mars_simulant --measured config/bulk/mars_simulant.yaml --out "
      "calibration");
  command->callback([options] { run(*options); });
}

}  // namespace wheel_twin::cli
