// One step of the rig as it was: the true state, and what perfect sensors would log of it. Observers (nodes,
// plots) get it by reference, valid during the call. Frame `rig`: x along travel, y to the left, z up, z = 0
// at the undisturbed soil.
#pragma once

#include <functional>

#include "rig/contact.h"
#include "rig/ports.h"

namespace wheel_twin::rig {

/// What the joint encoders and the drive log.
struct JointReading {
  double carriage_position = 0.0;  ///< m, from the start of the run
  double carriage_velocity = 0.0;  ///< m/s
  double wheel_angle = 0.0;        ///< rad, encoder's origin
  double wheel_rate = 0.0;         ///< rad/s
  double wheel_effort = 0.0;       ///< motor torque at the wheel shaft (after the gear), N m
};

/// Readings after the sensor ports, before noise, filter, range and resolution.
struct Readings {
  WrenchReading wrench;       ///< sensor axes, tared with the wheel hanging, N and N m
  double displacement = 0.0;  ///< m, positive down; a draw wire logs it with stamp time + draw_wire_delay
  JointReading joints;
  double temperature = 22.0;  ///< degrees C
};

struct RigStep {
  RigState state;
  HubMotion motion;          ///< true pose of the hub
  HubLoad load;              ///< true force on the hub
  double friction = 0.0;     ///< of the vertical guide on the slide, N, positive up
  bool hoist_taut = false;   ///< the rope still carries part of the weight
  double dead_weight = 0.0;  ///< weight the soil carries at rest without friction, N
  Readings readings;
};

using Observer = std::function<void(const RigStep&)>;

}  // namespace wheel_twin::rig
