#include "rig/sensor_settings.h"

#include <fmt/format.h>

namespace wheel_twin::rig {
namespace {

constexpr yaml::Range rates{1e-3, 1e5};  // Hz

/// Six values of a key with the sub-keys force and torque, three numbers each.
Vector6 read_axes(const yaml::Map& map, const std::string& key, yaml::Range range) {
  const yaml::Map axes = map.map(key);
  Vector6 values;
  int next = 0;
  for (const char* part : {"force", "torque"}) {
    const std::vector<double> numbers = axes.numbers(part, range);
    if (numbers.size() != 3)
      axes.fail(part, fmt::format("three numbers (x, y, z) are expected, not {}", numbers.size()));
    for (const double number : numbers) values[next++] = number;
  }
  axes.finish();
  return values;
}

}  // namespace

FtSettings read_ft(const yaml::Map& map) {
  FtSettings ft;
  ft.name = map.text("name");
  ft.rate = map.number("rate", rates);
  ft.range = read_axes(map, "range", yaml::positive());
  ft.resolution = read_axes(map, "resolution", yaml::non_negative());
  ft.noise = read_axes(map, "noise", yaml::non_negative());
  ft.low_pass = map.optional_number("low_pass", yaml::positive()).value_or(0.0);
  if (map.has("bias")) ft.bias = read_axes(map, "bias", {});
  if (map.has("drift")) ft.drift = read_axes(map, "drift", {});
  ft.tool_weight = map.number_or("tool_weight", ft.tool_weight, yaml::non_negative());
  map.finish();
  return ft;
}

DrawWireSettings read_draw_wire(const yaml::Map& map) {
  DrawWireSettings wire;
  wire.name = map.text("name");
  wire.rate = map.number("rate", rates);
  wire.range = map.number("range", yaml::positive());
  wire.wire_at_zero = map.number("wire_at_zero", yaml::non_negative());
  if (wire.wire_at_zero > wire.range)
    map.fail("wire_at_zero", fmt::format("{} m is beyond the range of {} m", wire.wire_at_zero, wire.range));
  wire.resolution = map.number("resolution", yaml::non_negative());
  wire.linearity = map.number("linearity", {0.0, 0.1});
  wire.noise = map.number("noise", yaml::non_negative());
  wire.tension = map.number("tension", yaml::non_negative());
  wire.tension_hysteresis = map.number("tension_hysteresis", yaml::non_negative());
  wire.tension_trimmed = map.boolean("tension_trimmed");
  map.finish();
  return wire;
}

JointSettings read_joints(const yaml::Map& map) {
  JointSettings joints;
  joints.name = map.text("name");
  joints.rate = map.number("rate", rates);
  joints.carriage_resolution = map.number("carriage_resolution", yaml::non_negative());
  joints.wheel_resolution = map.number("wheel_resolution", yaml::non_negative());
  joints.carriage_velocity_noise = map.number("carriage_velocity_noise", yaml::non_negative());
  joints.wheel_rate_noise = map.number("wheel_rate_noise", yaml::non_negative());
  joints.effort_noise = map.number("effort_noise", yaml::non_negative());
  joints.effort_resolution = map.number("effort_resolution", yaml::non_negative());
  map.finish();
  return joints;
}

TemperatureSettings read_temperature(const yaml::Map& map) {
  TemperatureSettings temperature;
  temperature.name = map.text("name");
  temperature.rate = map.number("rate", rates);
  temperature.noise = map.number("noise", yaml::non_negative());
  temperature.resolution = map.number("resolution", yaml::non_negative());
  map.finish();
  return temperature;
}

}  // namespace wheel_twin::rig
