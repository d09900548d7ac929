// Rules on what the numbers can be: units and signs, of joints against themselves and of forces against what
// was declared.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "logs/check_rules.h"
#include "logs/statistics.h"
#include "logs/topics.h"

namespace wheel_twin::logs::rules {
namespace {

constexpr double rolling_share = 0.5;  // of the wheel's usual speed: above it the wheel rolls
constexpr double column_units = 2.0;   // a position and its own rate that differ by more have different units
constexpr double column_tolerance = 0.1;
constexpr double largest_force = 5000.0;      // N on a bench rig, where no load is declared
constexpr double largest_displacement = 1.0;  // m, where no radius is declared
constexpr double largest_lever = 5.0;         // m: torque over force
constexpr double least_lever = 1e-4;          // m
constexpr double least_displacement = 2e-5;   // m under load
constexpr double factor_of_units = 30.0;      // between a slip or dead weight that is off and another unit
constexpr double load_tolerance = 0.3;
constexpr double speed_tolerance = 0.1;
constexpr double slip_tolerance = 0.1;
constexpr double clear_slip = 0.3;            // beyond it the sign of the pull is sure on level ground
constexpr double clear_pull = 0.1;            // of the load
constexpr double clear_force = 1.0;           // N
constexpr double clear_displacement = 0.001;  // m
constexpr double initial_part = 1.0;          // s

double total_change(const std::vector<double>& values, double wrap) {
  double sum = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    double step = values[i] - values[i - 1];
    if (wrap > 0.0) step = std::remainder(step, wrap);
    sum += step;
  }
  return sum;
}

double integral(const std::vector<double>& time, const std::vector<double>& rate) {
  double sum = 0.0;
  for (std::size_t i = 1; i < time.size(); ++i)
    sum += 0.5 * (rate[i] + rate[i - 1]) * (time[i] - time[i - 1]);
  return sum;
}

/// A position against the integral of its rate.
void check_rate_of(const char* what, const char* units, const std::vector<double>& time,
                   const std::vector<double>& position, const std::vector<double>& rate, double wrap,
                   double least, Findings& findings) {
  if (time.size() < 2 || position.empty() || rate.empty()) return;
  const double moved = total_change(position, wrap);
  const double expected = integral(time, rate);
  if (std::max(std::abs(moved), std::abs(expected)) < least) return;
  const double ratio = moved / expected;
  const std::string numbers =
      fmt::format("{} changes by {:.4g} where its velocity gives {:.4g} ({})", what, moved, expected, units);
  if (ratio < 0.0 && std::abs(ratio) > 0.1)
    findings.error("sign", joints_topic, 1, time.front(), numbers + ": one of the two has the wrong sign");
  else if (!(ratio > 1.0 / column_units && ratio < column_units))
    findings.error("units", joints_topic, 1, time.front(),
                   numbers + ": another unit, or one of the two is stuck");
  else if (std::abs(ratio - 1.0) > column_tolerance)
    findings.warning("units", joints_topic, 1, time.front(), numbers);
}

struct Motion {
  double carriage = std::numeric_limits<double>::quiet_NaN();  // m/s, median of the steady part
  double wheel = std::numeric_limits<double>::quiet_NaN();     // rad/s
  double effort = std::numeric_limits<double>::quiet_NaN();    // N m
};

Motion steady_motion(const run_log::RunLog& log) {
  const auto part = steady_part(log);
  const run_log::JointSeries& joints = log.joints;
  Motion motion;
  if (!joints.carriage_velocity.empty())
    motion.carriage = median_in(joints.time, joints.carriage_velocity, part);
  if (!joints.wheel_rate.empty()) motion.wheel = median_in(joints.time, joints.wheel_rate, part);
  if (!joints.wheel_effort.empty()) motion.effort = median_in(joints.time, joints.wheel_effort, part);
  return motion;
}

double slip_of(double speed, double rim_speed) {
  if (rim_speed == 0.0 && speed == 0.0) return 0.0;
  return std::abs(rim_speed) >= std::abs(speed) ? 1.0 - speed / rim_speed : rim_speed / speed - 1.0;
}

bool is_other_unit(double ratio) {
  return ratio > factor_of_units || ratio < 1.0 / factor_of_units;
}

}  // namespace

std::vector<double> force_axis(const run_log::RunLog& log, int axis) {
  std::vector<double> values(log.ft.force.size());
  std::transform(log.ft.force.begin(), log.ft.force.end(), values.begin(),
                 [axis](const auto& v) { return v[axis]; });
  return values;
}

std::vector<double> torque_axis(const run_log::RunLog& log, int axis) {
  std::vector<double> values(log.ft.torque.size());
  std::transform(log.ft.torque.begin(), log.ft.torque.end(), values.begin(),
                 [axis](const auto& v) { return v[axis]; });
  return values;
}

double median_in(const std::vector<double>& time, const std::vector<double>& value,
                 std::pair<double, double> part) {
  std::vector<double> inside;
  for (std::size_t i = 0; i < time.size(); ++i)
    if (time[i] >= part.first && time[i] <= part.second) inside.push_back(value[i]);
  return median(std::move(inside));
}

std::pair<double, double> steady_part(const run_log::RunLog& log) {
  const run_log::JointSeries& joints = log.joints;
  std::vector<double> speeds;
  const bool has_wheel = !joints.wheel_rate.empty();
  const bool has_carriage = !joints.carriage_velocity.empty();
  // Wheel or carriage: a locked wheel is dragged, a wheel on the spot spins. The speed that stands out is
  // taken.
  const auto usual = [](std::vector<double> values) {
    for (double& value : values) value = std::abs(value);
    return quantile(std::move(values), 0.8);
  };
  const double wheel = has_wheel ? usual(joints.wheel_rate) : 0.0;
  const double carriage = has_carriage ? usual(joints.carriage_velocity) : 0.0;
  double begin = 0.0;
  double end = 0.0;
  bool found = false;
  for (std::size_t i = 0; i < joints.time.size(); ++i) {
    const bool rolls = (wheel > 1e-4 && std::abs(joints.wheel_rate[i]) > rolling_share * wheel) ||
                       (carriage > 1e-5 && std::abs(joints.carriage_velocity[i]) > rolling_share * carriage);
    if (!rolls) continue;
    if (!found) begin = joints.time[i];
    found = true;
    end = joints.time[i];
  }
  if (found) return {begin + 0.3 * (end - begin), end};  // without lowering and run-in
  const double infinity = std::numeric_limits<double>::infinity();
  return {-infinity, infinity};
}

void check_joints(const run_log::RunLog& log, const Declared& declared, Findings& findings) {
  const run_log::JointSeries& joints = log.joints;
  if (joints.time.empty()) return;
  const auto part = steady_part(log);
  const double at = std::isfinite(part.first) ? part.first : joints.time.front();
  check_rate_of("carriage position", "m", joints.time, joints.carriage_position, joints.carriage_velocity,
                0.0, 0.01, findings);
  check_rate_of("wheel angle", "rad", joints.time, joints.wheel_angle, joints.wheel_rate,
                2.0 * 3.14159265358979323846, 0.1, findings);
  const Motion motion = steady_motion(log);
  if (motion.carriage * motion.wheel < 0.0 && std::abs(motion.wheel) > 0.01 &&
      std::abs(motion.carriage) > 1e-3)
    findings.warning("sign", joints_topic, 1, at,
                     fmt::format("carriage moves at {:+.4g} m/s while the wheel turns at {:+.4g} rad/s",
                                 motion.carriage, motion.wheel));
  if (declared.wheel_speed && std::abs(*declared.wheel_speed) > 1e-3) {
    const double ratio = motion.wheel / *declared.wheel_speed;
    if (is_other_unit(std::abs(ratio)) && std::abs(motion.wheel) > 1e-3)
      findings.error("units", joints_topic, 1, at,
                     fmt::format("wheel velocity {:.4g} rad/s is {:.4g} times the declared {:.4g} rad/s",
                                 motion.wheel, ratio, *declared.wheel_speed));
    else if (std::abs(ratio - 1.0) > speed_tolerance)
      findings.warning("declared", joints_topic, 1, at,
                       fmt::format("wheel velocity {:.4g} rad/s, declared are {:.4g} rad/s", motion.wheel,
                                   *declared.wheel_speed));
  }
  const double implied = std::abs(motion.carriage / motion.wheel);
  if (!declared.wheel_radius && std::isfinite(implied) && std::abs(motion.wheel) > 0.01 && implied > 20.0)
    findings.error(
        "units", joints_topic, 1, at,
        fmt::format("carriage {:.4g} m/s at a wheel of {:.4g} rad/s would need a radius of {:.4g} m",
                    motion.carriage, motion.wheel, implied));
  if (!declared.wheel_radius) return;
  const double rim = *declared.wheel_radius * motion.wheel;
  if (declared.slip && std::abs(*declared.slip) < 0.9 && std::abs(rim) > 1e-5 &&
      std::abs(motion.carriage) > 1e-5 && is_other_unit(std::abs(motion.carriage / rim))) {
    findings.error(
        "units", joints_topic, 1, at,
        fmt::format("carriage {:.4g} m/s against a rim speed of {:.4g} m/s", motion.carriage, rim));
  } else if (declared.slip) {
    const double slip = slip_of(motion.carriage, rim);
    if (std::abs(slip - *declared.slip) > slip_tolerance)
      findings.warning(
          "declared", joints_topic, 1, at,
          fmt::format("slip {:.3f} by the measured speeds, declared is {:.3f}", slip, *declared.slip));
  }
}

void check_units(const run_log::RunLog& log, const Declared& declared, Findings& findings) {
  const auto part = steady_part(log);
  const double no_time = std::numeric_limits<double>::quiet_NaN();
  const double at = std::isfinite(part.first) ? part.first : no_time;
  const double normal = median_in(log.ft.time, force_axis(log, 2), part);
  if (declared.load && *declared.load > 0.0 && std::isfinite(normal)) {
    const double ratio = normal / *declared.load;
    if (is_other_unit(std::abs(ratio)))
      findings.error("units", wrench_topic, log.ft.time.size(), at,
                     fmt::format("Fz is {:.4g} N, {:.4g} times the declared load of {:.4g} N", normal, ratio,
                                 *declared.load));
    else if (ratio > 0.0 && std::abs(ratio - 1.0) > load_tolerance)
      findings.warning("declared", wrench_topic, log.ft.time.size(), at,
                       fmt::format("Fz is {:.4g} N, the declared load {:.4g} N", normal, *declared.load));
  } else if (std::abs(normal) > largest_force) {
    findings.error(
        "units", wrench_topic, log.ft.time.size(), at,
        fmt::format("Fz is {:.4g} N: not in newtons, or no bench rig (then declare the load)", normal));
  }
  std::vector<double> forces(log.ft.force.size());
  std::vector<double> torques(log.ft.torque.size());
  for (std::size_t i = 0; i < forces.size(); ++i) {
    forces[i] = log.ft.force[i].norm();
    torques[i] = log.ft.torque[i].norm();
  }
  const double force = median_in(log.ft.time, forces, part);
  const double torque = median_in(log.ft.time, torques, part);
  if (force > clear_force && torque / force > largest_lever)
    findings.error("units", wrench_topic, log.ft.time.size(), at,
                   fmt::format("torque {:.4g} N m to a force of {:.4g} N is a lever of {:.4g} m: not in N m",
                               torque, force, torque / force));
  else if (force > clear_force && torque / force < least_lever)
    findings.warning(
        "units", wrench_topic, log.ft.time.size(), at,
        fmt::format(
            "torque {:.4g} N m to a force of {:.4g} N is a lever of {:.2g} m: not in N m, or not wired",
            torque, force, torque / force));
  const Motion motion = steady_motion(log);
  const double largest = declared.wheel_radius ? factor_of_units * *declared.wheel_radius : largest_lever;
  if (force > clear_force && std::abs(motion.effort) / force > largest)
    findings.error(
        "units", joints_topic, log.joints.time.size(), at,
        fmt::format("motor effort {:.4g} N m to a force of {:.4g} N: not in N m", motion.effort, force));
  const double displacement = median_in(log.draw_wire.time, log.draw_wire.value, part);
  const double deepest = declared.wheel_radius ? 2.0 * *declared.wheel_radius : largest_displacement;
  if (std::abs(displacement) > deepest)
    findings.error(
        "units", displacement_topic, log.draw_wire.time.size(), at,
        fmt::format("hub displacement {:.4g} m {}: not in metres", displacement,
                    declared.wheel_radius ? "is more than the wheel's diameter" : "is no bench rig's"));
  else if (std::abs(normal) > clear_force && std::abs(displacement) < least_displacement &&
           std::isfinite(part.first))
    findings.warning("units", displacement_topic, log.draw_wire.time.size(), at,
                     fmt::format("hub displacement {:.2g} m under {:.4g} N: not in metres, or not wired",
                                 displacement, normal));
}

void check_signs(const run_log::RunLog& log, const Declared& declared, Findings& findings) {
  const auto part = steady_part(log);
  const double at = std::isfinite(part.first) ? part.first : 0.0;
  const std::vector<double> normal = force_axis(log, 2);
  const double load = median_in(log.ft.time, normal, part);
  if (load < -clear_force)
    findings.error(
        "sign", wrench_topic, log.ft.time.size(), at,
        fmt::format("normal load Fz is {:.4g} N: the soil pushes the wheel up, so it must be positive",
                    load));
  // From hanging free to loaded, the hub goes down.
  std::vector<double> free;
  std::vector<double> loaded;
  for (std::size_t i = 0;
       i < log.draw_wire.time.size() && !log.ft.time.empty() && std::abs(load) > clear_force; ++i) {
    const double share = std::abs(interpolate(log.ft.time, normal, log.draw_wire.time[i]) / load);
    if (share < 0.1) free.push_back(log.draw_wire.value[i]);
    if (share > 0.5) loaded.push_back(log.draw_wire.value[i]);
  }
  const double sinkage = median(loaded) - median(free);
  const double displacement = median_in(log.draw_wire.time, log.draw_wire.value, part);
  const double begin = log.draw_wire.time.empty() ? 0.0 : log.draw_wire.time.front();
  if (free.size() >= 20 && loaded.size() >= 20 && sinkage < -clear_displacement)
    findings.error(
        "sign", displacement_topic, log.draw_wire.time.size(), log.draw_wire.time.front(),
        fmt::format("the hub rises by {:.4g} m when the load comes on: displacement is positive down",
                    -sinkage));
  // A log that begins under load begins below first touch; later a rising soil may lift the hub.
  const double initial = median_in(log.draw_wire.time, log.draw_wire.value, {begin, begin + initial_part});
  const double initial_load = median_in(log.ft.time, normal, {begin, begin + initial_part});
  if (free.size() < 20 && std::abs(initial_load) > 0.5 * std::abs(load) && initial < -clear_displacement)
    findings.error("sign", displacement_topic, log.draw_wire.time.size(), begin,
                   fmt::format("hub displacement is {:.4g} m under {:.4g} N: displacement is positive down",
                               initial, initial_load));
  else if (log.ft.time.empty() && displacement < -clear_displacement)
    findings.warning(
        "sign", displacement_topic, log.draw_wire.time.size(), at,
        fmt::format("hub displacement is {:.4g} m while the wheel runs: positive is down, 0 at first touch",
                    displacement));
  if (log.ft.time.empty() || !(std::abs(load) > clear_force) || declared.pressing) return;
  const double pull = median_in(log.ft.time, force_axis(log, 0), part);
  const Motion motion = steady_motion(log);
  if (declared.wheel_radius && std::isfinite(motion.carriage) && std::isfinite(motion.wheel)) {
    const double direction = motion.carriage < 0.0 ? -1.0 : 1.0;
    const double slip =
        slip_of(direction * motion.carriage, direction * *declared.wheel_radius * motion.wheel);
    const double forward = direction * pull;
    if ((slip > clear_slip && forward < -clear_pull * std::abs(load)) ||
        (slip < -clear_slip && forward > clear_pull * std::abs(load)))
      findings.error("sign", wrench_topic, log.ft.time.size(), at,
                     fmt::format("drawbar pull Fx is {:.4g} N at slip {:.2f}: wrong sign", pull, slip));
  } else if (motion.effort * motion.wheel > 0.0 && pull * motion.wheel < 0.0 &&
             std::abs(pull) > clear_slip * std::abs(load)) {
    findings.error(
        "sign", wrench_topic, log.ft.time.size(), at,
        fmt::format("drawbar pull Fx is {:.4g} N while the motor drives with {:.4g} N m: wrong sign", pull,
                    motion.effort));
  }
}

}  // namespace wheel_twin::logs::rules
