// A rig as its YAML describes it (config/rigs), and what the operator sets for one run. SI units.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/yaml.h"

namespace wheel_twin::rig {

/// Belt-driven carriage. The encoder sits on the motor: what the belt gives way to is not logged.
struct CarriageSettings {
  double speed_lag = 0.02;               ///< first-order lag of the speed controller, s; 0: none
  std::optional<double> belt_stiffness;  ///< N/m, none: rigid belt
  double belt_lag = 0.02;                ///< time constant of the belt's deflection, s
  double stroke = 2.0;                   ///< m, a longer run is refused
};

/// Vertical guide.
struct SlideSettings {
  double viscous_damping = 60.0;  ///< N s/m
  double coulomb_friction = 0.0;  ///< N, at least 0
  std::optional<double> mass;     ///< of all that moves vertically, kg; none: load / g
  double travel_below = 0.15;     ///< lowest hub displacement, m; deeper is an error
};

/// Speed-controlled wheel drive; torques and inertias at the wheel shaft (after the gear).
struct DriveSettings {
  double speed_lag = 0.02;        ///< first-order lag of the speed controller, s; 0: none
  double inertia = 0.02;          ///< rotor through the gear, and wheel, kg m^2
  double viscous_loss = 0.0;      ///< N m s/rad
  double coulomb_loss = 0.0;      ///< N m while turning
  double free_inertia = 0.005;    ///< of a towed wheel, drive uncoupled, kg m^2
  double bearing_friction = 0.0;  ///< of a towed wheel, N m while turning
};

/// Where the force/torque sensor is fixed, and what it carries. doc/physics.md, "Rig and sensors", has the
/// statics.
struct MountSettings {
  double arm_x = 0.0;  ///< sensor origin from the hub, rig axes, m
  double arm_y = 0.0;
  double arm_z = 0.03;
  double tool_mass = 2.0;  ///< between sensor and soil (wheel, motor, bracket), kg
  /// Share of the drive torque in the reading about the axle: -1 by statics when the motor hangs on the tool
  /// side (the soil's torque on the wheel goes through the sensor), 0 when a torque arm leads it past the
  /// sensor.
  double drive_torque_share = -1.0;
};

struct RigSettings {
  std::string name = "rig";
  CarriageSettings carriage;
  SlideSettings slide;
  DriveSettings drive;
  MountSettings mount;
  double steering_limit = 0.4363323;  ///< rad (25 degrees)
  double gravity = 9.80665;           ///< m/s^2
};

/// Throws Error naming file, line and key.
RigSettings read_rig(const yaml::Map& map);

/// What the operator sets.
struct RunConditions {
  double slip = 0.0;              ///< -1 to 1
  double load = 42.1;             ///< force the soil carries at rest, N
  double wheel_speed = 0.285885;  ///< rad/s, see speeds_of_slip
  double steering_angle = 0.0;    ///< rad, wheel turned to the left when positive
  bool towed = false;             ///< drive uncoupled; the carriage runs at radius times wheel_speed
  double temperature = 22.0;      ///< degrees C
  double temperature_rate = 0.0;  ///< of the sensor while the run lasts, K/s
  double wheel_angle = 0.0;       ///< rad, encoder at the start
};

}  // namespace wheel_twin::rig
