#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/atomic_file.h"
#include "base/config_path.h"
#include "base/error.h"
#include "cli/commands.h"
#include "terramechanics/ground_pressure.h"
#include "terramechanics/wheel_on_soil.h"

namespace wheel_twin::cli {
namespace {

using terramechanics::ContactState;
using terramechanics::Soil;
using terramechanics::Wheel;

constexpr double degree = 3.14159265358979323846 / 180.0;

struct Options {
  std::string wheel = "amalia", soil = "mars_simulant", out;
  std::vector<double> loads = {42.1}, slips;
  double steering_degrees = 0.0;
  bool towed = false;
  std::vector<std::string> changes;
};

/// "soil.K=0.025", "wheel.stiffness=9000" ("none": rigid).
void change(const std::string& text, Wheel& wheel, Soil& soil) {
  const std::size_t equals = text.find('=');
  const std::string key = text.substr(0, equals);
  const std::string word = equals == std::string::npos ? "" : text.substr(equals + 1);
  if (key == "wheel.stiffness" && word == "none") {
    wheel.stiffness.reset();
    return;
  }
  double value = 0.0;
  if (!CLI::detail::lexical_cast(word, value) || !std::isfinite(value)) {
    throw Error(fmt::format("--set {}: '{}' is not a number", key, word));
  }
  const std::vector<std::pair<std::string, double*>> numbers = {
      {"wheel.radius", &wheel.radius},
      {"wheel.width", &wheel.width},
      {"wheel.grouser_height", &wheel.grouser_height},
      {"wheel.flexing_resistance", &wheel.flexing_resistance},
      {"soil.k_c", &soil.k_c},
      {"soil.k_phi", &soil.k_phi},
      {"soil.n", &soil.n},
      {"soil.c", &soil.c},
      {"soil.phi", &soil.phi},
      {"soil.K", &soil.K},
      {"soil.c1", &soil.c1},
      {"soil.c2", &soil.c2},
      {"soil.gamma", &soil.gamma},
      {"soil.weight_density", &soil.weight_density}};
  for (const auto& [name, number] : numbers) {
    if (name == key) {
      *number = value;
      return;
    }
  }
  if (key == "wheel.stiffness" && value > 0.0) {
    wheel.stiffness = value;
  } else if (key == "wheel.grousers" && value >= 0.0 && value == std::floor(value)) {
    wheel.grousers = static_cast<int>(value);
  } else {
    throw Error(fmt::format("--set {}: no such key, or {} does not fit it", key, word));
  }
}

std::string row(double slip, const ContactState& s) {
  return fmt::format(
      "{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n",
      slip, s.normal_load, s.drawbar_pull, s.side_force, s.drive_torque, 1e3 * s.sinkage, 1e3 * s.deflection,
      1e3 * s.hub_displacement, s.entry_angle / degree, s.exit_angle / degree, s.thrust, s.grouser_thrust,
      s.compaction_resistance, s.grousers_in_soil);
}

void steady(const Options& options) {
  Wheel wheel = terramechanics::read_wheel(yaml::parse_file(find_config("wheels", options.wheel)));
  Soil soil = terramechanics::read_soil(yaml::parse_file(find_config("soils", options.soil)));
  for (const std::string& text : options.changes) change(text, wheel, soil);
  const terramechanics::WheelOnSoil model(wheel, soil);
  std::string csv =
      "slip,load_n,drawbar_pull_n,side_force_n,drive_torque_nm,sinkage_mm,deflection_mm,hub_displacement_mm,"
      "entry_deg,exit_deg,"
      "thrust_n,grouser_thrust_n,compaction_resistance_n,grousers_in_soil\n";
  const double steering = options.steering_degrees * degree;
  for (const double load : options.loads) {
    std::vector<double> slips = options.slips;
    if (options.towed) slips = {model.towed_slip(load, steering)};
    for (const double slip : slips) csv += row(slip, model.at_load(load, {slip, steering}));
    fmt::print(
        stderr,
        "{:g} N: mean pressure on hard ground {:.2f} kPa, critical {:.2f} kPa: {} by the paper's rule\n",
        load, 1e-3 * terramechanics::hard_ground_pressure(wheel, load),
        1e-3 * terramechanics::critical_ground_pressure(wheel, soil, load),
        terramechanics::works_as_flexible(wheel, soil, load) ? "flexible" : "rigid");
  }
  if (options.out.empty()) {
    fmt::print("{}", csv);
  } else {
    write_file(options.out, csv);
  }
}

}  // namespace

void add_steady(CLI::App& app) {
  auto options = std::make_shared<Options>();
  for (int i = 0; i <= 12; ++i) options->slips.push_back(0.05 * i);
  CLI::App* command =
      app.add_subcommand("steady", "Steady state of the semi-empirical model against slip, as CSV");
  command->add_option("--wheel", options->wheel, "name in config/wheels or a file")->capture_default_str();
  command->add_option("--soil", options->soil, "name in config/soils or a file")->capture_default_str();
  command->add_option("--load", options->loads, "N, one or several separated by commas")->delimiter(',');
  command->add_option("--slip", options->slips, "-1 to 1, separated by commas (default 0 to 0.6)")
      ->delimiter(',');
  command->add_option("--steering-angle", options->steering_degrees,
                      "degrees, wheel turned to the left when positive");
  command->add_flag("--towed", options->towed, "solve for the slip at which the wheel needs no torque");
  command
      ->add_option("--set", options->changes,
                   "changes a number, e.g. soil.K=0.03 or wheel.stiffness=none; repeatable")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "CSV file (default: standard output)");
  command->footer(
      "Example:\n  twin steady --wheel amalia --soil mars_simulant --load 42.1 --slip 0.2,0.4,0.6 --set "
      "soil.K=0.03");
  command->callback([options] { steady(*options); });
}

}  // namespace wheel_twin::cli
