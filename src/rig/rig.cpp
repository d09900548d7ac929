#include "rig/rig.h"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <Eigen/Geometry>
#include <cmath>

#include "base/error.h"
#include "rig/slide.h"
#include "rig/speed_lag.h"
#include "rig/speeds.h"

namespace wheel_twin::rig {
namespace {

double sign_of(double x) {
  return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0;
}

/// What all rig ports together do at a state.
struct RigActions {
  double dead_weight = 0.0;
  double coulomb = 0.0;
  double speed_factor = 1.0;
  double steering = 0.0;
  double motor_drag = 0.0;

  RigActions(const std::vector<const RigPort*>& ports, const RigState& state) {
    for (const RigPort* port : ports) {
      dead_weight += port->added_dead_weight(state);
      coulomb += port->coulomb_friction(state);
      speed_factor *= port->speed_factor(state);
      steering += port->added_steering(state);
      motor_drag += port->motor_drag(state);
    }
  }
};

void check(const RigSettings& settings, const RunConditions& conditions, double radius) {
  const auto refuse = [&](const std::string& message) {
    throw Error(fmt::format("rig {}: {}", settings.name, message));
  };
  if (!(radius > 0.0)) refuse(fmt::format("a wheel of radius {} m", radius));
  if (!(conditions.load > 0.0) || !std::isfinite(conditions.load))
    refuse(fmt::format("the load must be above 0 N, not {}", conditions.load));
  if (!(std::abs(conditions.slip) <= 1.0))
    refuse(fmt::format("slip {} is not between -1 and 1", conditions.slip));
  if (!std::isfinite(conditions.wheel_speed))
    refuse(fmt::format("wheel speed {} rad/s", conditions.wheel_speed));
  constexpr double degree = 3.14159265358979323846 / 180.0;
  if (!(std::abs(conditions.steering_angle) <= settings.steering_limit + 1e-9))
    refuse(fmt::format("steering angle {:.3g} degrees is beyond the limit of {:.3g}",
                       conditions.steering_angle / degree, settings.steering_limit / degree));
}

}  // namespace

class Rig::Impl {
 public:
  Impl(const RigSettings& settings, const RunConditions& conditions, double radius, Contact& contact,
       Ports ports)
      : settings_(settings),
        conditions_(conditions),
        radius_(radius),
        contact_(contact),
        ports_(std::move(ports)) {
    check(settings_, conditions_, radius_);
    load_ = conditions_.load;
    steering_ = conditions_.steering_angle;
    wheel_angle_ = conditions_.wheel_angle;
    temperature_ = conditions_.temperature;
  }

  const RigStep& start(const MeasuredMotion& motion, std::optional<double> displacement) {
    time_ = motion.time;
    take_over(motion);
    motor_speed_ = motion.carriage_velocity;
    wheel_rate_ = motion.wheel_rate;
    wheel_angle_ = motion.wheel_angle;
    logged_position_ = motion.carriage_position;
    update_state();
    const RigActions actions(ports_.rig, state());
    carriage_speed_ = actions.speed_factor * motor_speed_;
    update_state();
    if (displacement) {
      height_ = -*displacement;
      step_.load = contact_.advance(motion_at(height_, 0.0, wheel_rate_, actions));
    } else {
      balance(actions, 0.0, "the rig can start");
    }
    finish(actions, 0.0, 0.0, 0.0);
    return step_;
  }

  const RigStep& start(std::optional<double> displacement) {
    MeasuredMotion rest;
    rest.wheel_angle = conditions_.wheel_angle;
    rest.load = conditions_.load;
    rest.steering_angle = conditions_.steering_angle;
    rest.temperature = conditions_.temperature;
    return start(rest, displacement);
  }

  const RigStep& advance(const Command& command, double dt) {
    const RigActions actions(ports_.rig, state());
    const Lagged motor = follow_lag(motor_speed_, command.carriage_speed, settings_.carriage.speed_lag, dt);
    const double acceleration = move_carriage(motor.integral, motor.value, actions, dt);
    if (std::abs(logged_position_) > settings_.carriage.stroke)
      throw Error(fmt::format("rig {}: the carriage leaves its stroke of {} m at {:.2f} s", settings_.name,
                              settings_.carriage.stroke, time_ + dt));
    time_ += dt;
    const double lift = move_slide(command.lowest_slide_velocity, actions, dt);
    const double rate_before = wheel_rate_;
    if (conditions_.towed) {
      roll_freely(actions, dt);
    } else {
      const Lagged wheel = follow_lag(wheel_rate_, command.wheel_rate, settings_.drive.speed_lag, dt);
      turn_wheel(wheel.integral, wheel.value);
      step_.load = contact_.advance(motion_at(height_, slide_velocity_, wheel_rate_, actions));
    }
    temperature_ = conditions_.temperature + conditions_.temperature_rate * time_;
    finish(actions, acceleration, lift, (wheel_rate_ - rate_before) / dt);
    return step_;
  }

  const RigStep& follow(const MeasuredMotion& motion, Slide slide) {
    const double dt = motion.time - time_;
    if (!(dt > 0.0))
      throw Error(fmt::format("the measured motion goes from {:.6f} s to {:.6f} s", time_, motion.time));
    take_over(motion);
    const RigActions actions(ports_.rig, state());
    const double rate_before = wheel_rate_;
    double acceleration =
        move_carriage(motion.carriage_position - logged_position_, motion.carriage_velocity, actions, dt);
    turn_wheel(motion.wheel_angle - wheel_angle_, motion.wheel_rate);
    time_ = motion.time;
    double lift = 0.0;
    double wheel_acceleration = 0.0;
    if (slide == Slide::dynamic) {
      lift = move_slide(std::nullopt, actions, dt);
      step_.load = contact_.advance(motion_at(height_, slide_velocity_, wheel_rate_, actions));
      wheel_acceleration = (wheel_rate_ - rate_before) / dt;
    } else {
      acceleration = 0.0;
      const double before = height_;
      balance(actions, coulomb(actions), "a quasi-static slide can be followed");
      slide_velocity_ = (height_ - before) / dt;
    }
    finish(actions, acceleration, lift, wheel_acceleration);
    return step_;
  }

  const RigStep& step() const { return step_; }

  double draw_wire_delay() const { return rig::draw_wire_delay(ports_); }

 private:
  const RigState& state() const { return step_.state; }
  double coulomb(const RigActions& actions) const {
    return settings_.slide.coulomb_friction + actions.coulomb;
  }
  double weight(const RigActions& actions) const {
    const double sum = load_ + actions.dead_weight;
    if (!(sum > 0.0))
      throw Error(fmt::format("rig {}: nothing presses the wheel down: {:.3g} N", settings_.name, sum));
    return sum;
  }

  void take_over(const MeasuredMotion& motion) {
    load_ = motion.load;
    steering_ = motion.steering_angle;
    temperature_ = motion.temperature;
  }

  void update_state() {
    RigState& state = step_.state;
    state.time = time_;
    state.x = x_;
    state.carriage_speed = carriage_speed_;
    state.wheel_angle = wheel_angle_;
    state.wheel_rate = wheel_rate_;
    state.rim_travel = rim_travel_;
    state.slip = slip_ratio(carriage_speed_, radius_ * wheel_rate_);
    state.hub_displacement = -height_;
    state.slide_velocity = slide_velocity_;
    state.steering_angle = steering_;
    state.temperature = temperature_;
  }

  HubMotion motion_at(double height, double velocity, double rate, const RigActions& actions) const {
    HubMotion motion;
    motion.time = time_;
    motion.position = {x_, 0.0, height};
    motion.velocity = {carriage_speed_, 0.0, velocity};
    motion.wheel_angle = wheel_angle_;
    motion.wheel_rate = rate;
    motion.steering_angle = steering_ + actions.steering;
    return motion;
  }

  /// Moves the carriage by what its encoder logs; returns the carriage's true acceleration, m/s^2.
  double move_carriage(double travel, double speed, const RigActions& actions, double dt) {
    double belt_travel = 0.0;
    if (settings_.carriage.belt_stiffness) {
      const double deflection = step_.load.force_hub_rig.x() / *settings_.carriage.belt_stiffness;
      // The soil answers the deflection's speed by slip: it adds c/k to the lag (linearly implicit, c an
      // upper bound).
      const double faster = std::max(std::abs(speed), radius_ * std::abs(wheel_rate_));
      const double soil_resistance = 2.0 * step_.load.force_hub_rig.z() / std::max(faster, rest_speed);
      const double lag = settings_.carriage.belt_lag + soil_resistance / *settings_.carriage.belt_stiffness;
      const double moved = follow_lag(belt_deflection_, deflection, lag, dt).value;
      belt_travel = moved - belt_deflection_;
      belt_deflection_ = moved;
    }
    const double speed_before = carriage_speed_;
    logged_position_ += travel;
    motor_speed_ = speed;
    x_ += actions.speed_factor * travel + belt_travel;
    carriage_speed_ = actions.speed_factor * speed + belt_travel / dt;
    return (carriage_speed_ - speed_before) / dt;
  }

  /// Moves the slide by its dynamics; returns its acceleration, m/s^2, positive up.
  double move_slide(std::optional<double> lowest_velocity, const RigActions& actions, double dt) {
    SlideForces forces;
    forces.soil = step_.load.force_hub_rig.z();
    forces.stiffness = step_.load.vertical_stiffness;
    forces.weight = weight(actions);
    forces.damping = settings_.slide.viscous_damping;
    forces.coulomb = coulomb(actions);
    const double mass = settings_.slide.mass ? *settings_.slide.mass : forces.weight / settings_.gravity;
    const SlideVelocity moved = rig::slide_velocity(forces, mass, slide_velocity_, dt, lowest_velocity);
    const double acceleration = (moved.velocity - slide_velocity_) / dt;
    slide_velocity_ = moved.velocity;
    height_ += moved.velocity * dt;
    step_.friction = moved.friction;
    step_.hoist_taut = moved.held;
    if (!std::isfinite(height_))
      throw Error(fmt::format("the slide's height is {} at {:.4f} s", height_, time_));
    if (-height_ > settings_.slide.travel_below)
      throw Error(fmt::format(
          "the slide meets its lower stop, {:.0f} mm down, at {:.2f} s: the soil does not carry {:.3g} N",
          1e3 * settings_.slide.travel_below, time_, forces.weight));
    return acceleration;
  }

  /// Puts the slide in equilibrium at the present time.
  void balance(const RigActions& actions, double coulomb_force, const char* purpose) {
    if (!contact_.repeatable())
      throw Error(fmt::format("{} in equilibrium only on a contact that can be evaluated again", purpose));
    const auto soil_at = [&](double height) {
      return contact_.advance(motion_at(height, 0.0, wheel_rate_, actions));
    };
    SlideEquilibrium found;
    try {
      found =
          slide_equilibrium(soil_at, height_, weight(actions), coulomb_force, -settings_.slide.travel_below);
    } catch (const Error& error) {
      throw Error(fmt::format("rig {} at {:.3f} s: {}", settings_.name, time_, error.what()));
    }
    height_ = found.height;
    step_.friction = found.friction;
    step_.hoist_taut = false;
    step_.load = found.load;
  }

  void turn_wheel(double travel, double rate) {
    wheel_angle_ += travel;
    wheel_rate_ = rate;
    if (touched_) rim_travel_ += radius_ * std::abs(travel);
  }

  /// A towed wheel: inertia (w1 - w0)/dt = -torque(w1) - bearing friction, by secants where the contact
  /// allows.
  void roll_freely(const RigActions& actions, double dt) {
    const DriveSettings& drive = settings_.drive;
    const double before = wheel_rate_;
    const double angle_before = wheel_angle_;
    const double travel_before = rim_travel_;
    const auto unbalance = [&](double rate) {
      wheel_angle_ = angle_before;
      rim_travel_ = travel_before;
      turn_wheel(0.5 * (before + rate) * dt, rate);
      step_.load = contact_.advance(motion_at(height_, slide_velocity_, rate, actions));
      return drive.free_inertia * (rate - before) / dt + step_.load.drive_torque +
             drive.bearing_friction * std::tanh(rate / 1e-3);
    };
    if (!contact_.repeatable()) {
      const double resistance = step_.load.drive_torque + drive.bearing_friction * std::tanh(before / 1e-3);
      unbalance(before - dt * resistance / drive.free_inertia);
      return;
    }
    constexpr int most_iterations = 30;
    const double tolerance = 1e-9 * load_ * radius_;
    const double least_slope = drive.free_inertia / dt;
    double rate = before;
    double rest = unbalance(rate);
    for (int i = 0; i < most_iterations && std::abs(rest) > tolerance; ++i) {
      const double next = rate - rest / std::max(free_slope_, least_slope);
      const double next_rest = unbalance(next);
      if (next != rate) free_slope_ = std::max((next_rest - rest) / (next - rate), least_slope);
      rate = next;
      rest = next_rest;
    }
  }

  void finish(const RigActions& actions, double acceleration, double lift, double wheel_acceleration) {
    if (step_.load.force_hub_rig.z() > 0.0) touched_ = true;
    update_state();
    step_.motion = motion_at(height_, slide_velocity_, wheel_rate_, actions);
    step_.dead_weight = weight(actions);
    read_wrench(acceleration, lift);
    read_joints(actions, wheel_acceleration);
    Readings& readings = step_.readings;
    readings.displacement = -height_;
    for (const SensorPort* port : ports_.sensor)
      port->change_displacement(state(), step_.load.force_hub_rig.z(), readings.displacement);
    readings.temperature = temperature_;
  }

  /// Statics of the tool between soil and sensor, see doc/physics.md.
  void read_wrench(double acceleration, double lift) {
    const MountSettings& mount = settings_.mount;
    const HubLoad& load = step_.load;
    const Eigen::Vector3d inertia = mount.tool_mass * Eigen::Vector3d(acceleration, 0.0, lift);
    const Eigen::Vector3d hub_from_sensor(-mount.arm_x, -mount.arm_y, -mount.arm_z);
    const double steering = step_.motion.steering_angle;
    const Eigen::Vector3d axle(-std::sin(steering), std::cos(steering), 0.0);
    WrenchReading& wrench = step_.readings.wrench;
    wrench.force = load.force_hub_rig - inertia;
    wrench.torque = hub_from_sensor.cross(wrench.force) + load.torque_hub_rig +
                    (1.0 + mount.drive_torque_share) * load.drive_torque * axle;
    for (const SensorPort* port : ports_.sensor) port->change_wrench(state(), wrench);
  }

  void read_joints(const RigActions& actions, double wheel_acceleration) {
    const DriveSettings& drive = settings_.drive;
    JointReading& joints = step_.readings.joints;
    joints.carriage_position = logged_position_;
    joints.carriage_velocity = motor_speed_;
    joints.wheel_angle = wheel_angle_;
    joints.wheel_rate = wheel_rate_;
    joints.wheel_effort = 0.0;
    if (!conditions_.towed)
      joints.wheel_effort = step_.load.drive_torque + drive.inertia * wheel_acceleration +
                            drive.viscous_loss * wheel_rate_ +
                            (drive.coulomb_loss + actions.motor_drag) * sign_of(wheel_rate_);
    for (const SensorPort* port : ports_.sensor) port->change_motor_effort(state(), joints.wheel_effort);
  }

  RigSettings settings_;
  RunConditions conditions_;
  double radius_;
  Contact& contact_;
  Ports ports_;
  RigStep step_;

  double time_ = 0.0;
  double load_ = 0.0;
  double steering_ = 0.0;
  double temperature_ = 22.0;
  double logged_position_ = 0.0;  // of the carriage
  double motor_speed_ = 0.0;      // of the carriage, as logged
  double belt_deflection_ = 0.0;
  double x_ = 0.0;               // true
  double carriage_speed_ = 0.0;  // true
  double wheel_angle_ = 0.0;
  double wheel_rate_ = 0.0;
  double rim_travel_ = 0.0;
  double free_slope_ = 0.0;  // of a towed wheel's torque against its rate, N m s/rad
  double height_ = 0.0;
  double slide_velocity_ = 0.0;
  bool touched_ = false;
};

Rig::Rig(const RigSettings& settings, const RunConditions& conditions, double radius, Contact& contact,
         Ports ports)
    : impl_(std::make_unique<Impl>(settings, conditions, radius, contact, std::move(ports))) {}
Rig::~Rig() = default;
Rig::Rig(Rig&&) noexcept = default;

const RigStep& Rig::start(std::optional<double> displacement) {
  return impl_->start(displacement);
}
const RigStep& Rig::start(const MeasuredMotion& motion, std::optional<double> displacement) {
  return impl_->start(motion, displacement);
}
const RigStep& Rig::advance(const Command& command, double dt) {
  return impl_->advance(command, dt);
}
const RigStep& Rig::follow(const MeasuredMotion& motion, Slide slide) {
  return impl_->follow(motion, slide);
}
const RigStep& Rig::step() const {
  return impl_->step();
}
double Rig::draw_wire_delay() const {
  return impl_->draw_wire_delay();
}

}  // namespace wheel_twin::rig
