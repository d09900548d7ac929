#include "logs/experiment.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include "base/atomic_file.h"
#include "base/config_path.h"
#include "base/error.h"
#include "base/yaml.h"

namespace wheel_twin::logs {
namespace {

namespace fs = std::filesystem;

constexpr double pi = 3.14159265358979323846;

Role read_role(const yaml::Map& map) {
  const std::string text = map.text("role");
  for (const Role role : {Role::reference, Role::measured, Role::held_out})
    if (text == to_string(role)) return role;
  map.fail("role", fmt::format("'{}' is not one of reference, measured, held_out", text));
}

std::optional<Average> read_average(const yaml::Map& averages, const std::string& key) {
  if (!averages.has(key)) return std::nullopt;
  const yaml::Map map = averages.map(key);
  Average average;
  average.mean = map.number("mean");
  average.std = map.optional_number("std", yaml::non_negative());
  map.finish();
  return average;
}

Averages read_averages(const yaml::Map& map) {
  Averages averages;
  const std::vector<double> window = map.numbers("window", {0.0, 1e6});
  if (window.size() != 2 || window[1] <= window[0])
    map.fail("window", "two times [start, end] in s are expected");
  averages.window_start = window[0];
  averages.window_end = window[1];
  averages.drawbar_pull = read_average(map, "drawbar_pull");
  averages.side_force = read_average(map, "side_force");
  averages.normal_load = read_average(map, "normal_load");
  averages.hub_displacement = read_average(map, "hub_displacement");
  averages.pitch_torque = read_average(map, "pitch_torque");
  averages.motor_effort = read_average(map, "motor_effort");
  map.finish();
  if (!averages.drawbar_pull && !averages.side_force && !averages.normal_load && !averages.hub_displacement &&
      !averages.pitch_torque && !averages.motor_effort)
    map.fail("window", "no channel is averaged over it");
  return averages;
}

/// A file of the experiment: relative, inside the directory, existing, named once.
class Files {
 public:
  Files(std::string directory, Stage stage) : directory_(std::move(directory)), stage_(stage) {}

  Stage stage() const { return stage_; }

  std::optional<std::string> read(const yaml::Map& map, const std::string& key) {
    if (!map.has(key) || map.is_null(key)) return std::nullopt;
    std::string file = map.text(key);
    const fs::path normal = fs::path(file).lexically_normal();
    if (normal.is_absolute() || *normal.begin() == "..")
      map.fail(key, fmt::format("'{}' lies outside the directory of the experiment", file));
    if (stage_ == Stage::measured && !fs::is_regular_file(fs::path(directory_) / normal))
      map.fail(key, fmt::format("no file '{}' beside experiment.yaml", file));
    if (!seen_.insert(normal.string()).second)
      map.fail(key, fmt::format("'{}' stands here a second time", file));
    return file;
  }

 private:
  std::string directory_;
  Stage stage_;
  std::set<std::string> seen_;
};

Run read_run(const yaml::Map& map, Files& files) {
  Run run;
  if (!map.has("bag")) map.fail("bag", "is missing (write `bag: null` for a run without one)");
  run.bag = files.read(map, "bag");
  run.role = read_role(map);
  run.slip = map.number("slip", {-1.0, 1.0});
  run.load = map.number("load", {0.0, 1e5});
  run.wheel_speed = map.number("wheel_speed", {-1e3, 1e3});
  run.steering_angle = map.number("steering_angle", {-pi, pi});
  run.group = map.text_or("group", "");
  if (const auto averages = map.optional_map("averages")) run.averages = read_averages(*averages);
  map.finish();
  if (files.stage() == Stage::measured && !run.bag && !run.averages)
    map.fail("bag", "is null and there are no averages: nothing was measured");
  return run;
}

DeclaredSensor read_sensor(const yaml::Map& map) {
  DeclaredSensor sensor;
  sensor.rate = map.number("rate", {1e-3, 1e6});
  sensor.noise = map.number("noise", yaml::non_negative());
  sensor.resolution = map.number("resolution", yaml::non_negative());
  map.finish();
  return sensor;
}

void require_one_source(const yaml::Map& map, bool bag, bool csv) {
  if (bag == csv) map.fail(bag ? "csv" : "bag", "exactly one of bag and csv is expected");
}

PlateTest read_plate_test(const yaml::Map& map, Files& files) {
  PlateTest test;
  test.bag = files.read(map, "bag");
  test.csv = files.read(map, "csv");
  require_one_source(map, test.bag.has_value(), test.csv.has_value());
  test.indenter = map.text("indenter");
  if (test.indenter != "plate" && test.indenter != "wheel" && test.indenter != "rigid_floor")
    map.fail("indenter", fmt::format("'{}' is not one of plate, wheel, rigid_floor", test.indenter));
  test.diameter = map.optional_number("diameter", {1e-4, 10.0});
  test.width = map.optional_number("width", {1e-4, 10.0});
  test.length = map.optional_number("length", {1e-4, 10.0});
  if (test.width.has_value() != test.length.has_value())
    map.fail(test.width ? "length" : "width", "a rectangular plate has a width and a length");
  if (test.indenter == "plate" && test.diameter.has_value() == test.width.has_value())
    map.fail("diameter", "a plate has a diameter, or a width and a length");
  test.group = map.text_or("group", "");
  map.finish();
  return test;
}

DirectShear read_direct_shear(const yaml::Map& map, Files& files) {
  DirectShear test;
  test.bag = files.read(map, "bag");
  test.csv = files.read(map, "csv");
  require_one_source(map, test.bag.has_value(), test.csv.has_value());
  test.normal_stress = map.number("normal_stress", {0.0, 1e9});
  test.group = map.text_or("group", "");
  map.finish();
  return test;
}

// ---- writing
// ------------------------------------------------------------------------------------------------------

/// Shortest text that reads back as the same double; keeps a point or exponent so that it is a float to every
/// reader.
std::string number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) return text + ".0";
  const auto exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

/// Always quoted, so that no text is taken for a number, a boolean or null.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20)
      throw Error(fmt::format("experiment.yaml: control character in '{}'", text));
    result += c;
    if (c == '\'') result += c;
  }
  return result + "'";
}

std::string optional_text(const std::optional<std::string>& text) {
  return text ? quoted(*text) : "null";
}
std::string optional_number(const std::optional<double>& value) {
  return value ? number(*value) : "null";
}

std::string wheel_text(const terramechanics::Wheel& w) {
  return fmt::format("{{name: {}, radius: {}, width: {}, grousers: {}, grouser_height: {}, stiffness: {}}}",
                     quoted(w.name), number(w.radius), number(w.width), w.grousers, number(w.grouser_height),
                     optional_number(w.stiffness));
}

std::string soil_text(const terramechanics::Soil& s) {
  std::string text =
      fmt::format("{{name: {}, k_c: {}, k_phi: {}, n: {}, c: {}, phi: {}, K: {}, c1: {}, c2: {}, gamma: {}",
                  quoted(s.name), number(s.k_c), number(s.k_phi), number(s.n), number(s.c), number(s.phi),
                  number(s.K), number(s.c1), number(s.c2), number(s.gamma));
  if (s.weight_density != terramechanics::Soil{}.weight_density)
    text += fmt::format(", weight_density: {}", number(s.weight_density));
  return text + "}";
}

std::string averages_text(const Averages& averages) {
  std::string text =
      fmt::format("{{window: [{}, {}]", number(averages.window_start), number(averages.window_end));
  const auto channel = [&](const char* name, const std::optional<Average>& average) {
    if (!average) return;
    text += fmt::format(", {}: {{mean: {}", name, number(average->mean));
    if (average->std) text += fmt::format(", std: {}", number(*average->std));
    text += "}";
  };
  channel("drawbar_pull", averages.drawbar_pull);
  channel("side_force", averages.side_force);
  channel("normal_load", averages.normal_load);
  channel("hub_displacement", averages.hub_displacement);
  channel("pitch_torque", averages.pitch_torque);
  channel("motor_effort", averages.motor_effort);
  return text + "}";
}

std::string run_text(const Run& run) {
  std::string text =
      fmt::format("- {{bag: {}, role: {}, slip: {}, load: {}, wheel_speed: {}, steering_angle: {}",
                  optional_text(run.bag), to_string(run.role), number(run.slip), number(run.load),
                  number(run.wheel_speed), number(run.steering_angle));
  if (!run.group.empty()) text += fmt::format(", group: {}", quoted(run.group));
  if (run.averages) text += fmt::format(",\n   averages: {}", averages_text(*run.averages));
  return text + "}\n";
}

template <typename Test>
std::string source_text(const Test& test) {
  return test.bag ? fmt::format("bag: {}", quoted(*test.bag))
                  : fmt::format("csv: {}", quoted(test.csv.value_or("")));
}

std::string plate_test_text(const PlateTest& test) {
  std::string text = fmt::format("- {{{}, indenter: {}", source_text(test), test.indenter);
  if (test.diameter) text += fmt::format(", diameter: {}", number(*test.diameter));
  if (test.width) text += fmt::format(", width: {}", number(*test.width));
  if (test.length) text += fmt::format(", length: {}", number(*test.length));
  if (!test.group.empty()) text += fmt::format(", group: {}", quoted(test.group));
  return text + "}\n";
}

std::string direct_shear_text(const DirectShear& test) {
  std::string text = fmt::format("- {{{}, normal_stress: {}", source_text(test), number(test.normal_stress));
  if (!test.group.empty()) text += fmt::format(", group: {}", quoted(test.group));
  return text + "}\n";
}

std::string sensor_text(const DeclaredSensor& sensor) {
  return fmt::format("{{rate: {}, noise: {}, resolution: {}}}", number(sensor.rate), number(sensor.noise),
                     number(sensor.resolution));
}

}  // namespace

const char* to_string(Role role) {
  switch (role) {
    case Role::reference:
      return "reference";
    case Role::measured:
      return "measured";
    case Role::held_out:
      break;
  }
  return "held_out";
}

std::string Experiment::path_of(const std::string& file) const {
  return (fs::path(directory) / file).string();
}

Experiment read_experiment(const std::string& path, Stage stage) {
  const std::string file = fs::is_directory(path) ? (fs::path(path) / "experiment.yaml").string() : path;
  const std::string directory = fs::path(file).parent_path().string();
  return read_experiment(yaml::parse_file(file), directory.empty() ? "." : directory, stage);
}

Experiment read_experiment(const yaml::Map& map, const std::string& directory, Stage stage) {
  Experiment experiment;
  experiment.directory = directory;
  map.integer("schema", 1, 1);
  experiment.name = map.text("name");
  if (map.is_map("wheel")) {
    experiment.wheel = terramechanics::read_wheel(map.map("wheel"));
  } else {
    experiment.wheel_name = map.text("wheel");
    experiment.wheel =
        terramechanics::read_wheel(yaml::parse_file(find_config("wheels", *experiment.wheel_name)));
  }
  if (map.is_map("soil")) {
    experiment.soil = terramechanics::read_soil(map.map("soil"));
  } else {
    experiment.soil_name = map.text("soil");
    experiment.soil =
        terramechanics::read_soil(yaml::parse_file(find_config("soils", *experiment.soil_name)));
  }
  if (const auto sensors = map.optional_map("sensors")) {
    if (const auto ft = sensors->optional_map("ft")) experiment.ft = read_sensor(*ft);
    if (const auto draw_wire = sensors->optional_map("draw_wire"))
      experiment.draw_wire = read_sensor(*draw_wire);
    sensors->finish();
  }
  experiment.source = map.text_or("source", "");
  Files files(experiment.directory, stage);
  const yaml::List runs = map.list("runs");
  for (std::size_t i = 0; i < runs.size(); ++i) experiment.runs.push_back(read_run(runs.map(i), files));
  if (map.has("plate_tests")) {
    const yaml::List tests = map.list("plate_tests");
    for (std::size_t i = 0; i < tests.size(); ++i)
      experiment.plate_tests.push_back(read_plate_test(tests.map(i), files));
  }
  if (map.has("direct_shear")) {
    const yaml::List tests = map.list("direct_shear");
    for (std::size_t i = 0; i < tests.size(); ++i)
      experiment.direct_shear.push_back(read_direct_shear(tests.map(i), files));
  }
  map.finish();
  return experiment;
}

void write_experiment(const Experiment& experiment, const std::string& directory) {
  std::error_code code;
  fs::create_directories(directory, code);
  if (code) throw Error(fmt::format("{}: cannot be made: {}", directory, code.message()));
  std::string text = "schema: 1\n";
  text += fmt::format("name: {}\n", quoted(experiment.name));
  if (!experiment.source.empty()) text += fmt::format("source: {}\n", quoted(experiment.source));
  text += fmt::format("wheel: {}\n",
                      experiment.wheel_name ? quoted(*experiment.wheel_name) : wheel_text(experiment.wheel));
  text += fmt::format("soil: {}\n",
                      experiment.soil_name ? quoted(*experiment.soil_name) : soil_text(experiment.soil));
  if (experiment.ft || experiment.draw_wire) {
    text += "sensors: {";
    if (experiment.ft) text += "ft: " + sensor_text(*experiment.ft) + (experiment.draw_wire ? ", " : "");
    if (experiment.draw_wire) text += "draw_wire: " + sensor_text(*experiment.draw_wire);
    text += "}\n";
  }
  text += experiment.runs.empty() ? "runs: []\n" : "runs:\n";
  for (const Run& run : experiment.runs) text += run_text(run);
  if (!experiment.plate_tests.empty()) text += "plate_tests:\n";
  for (const PlateTest& test : experiment.plate_tests) text += plate_test_text(test);
  if (!experiment.direct_shear.empty()) text += "direct_shear:\n";
  for (const DirectShear& test : experiment.direct_shear) text += direct_shear_text(test);
  write_file((fs::path(directory) / "experiment.yaml").string(), text);
}

}  // namespace wheel_twin::logs
