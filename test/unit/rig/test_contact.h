// A soil of closed forms for the tests of the rig: a spring under the hub, thrust and torque proportional to
// slip, a side force proportional to the steering angle.
#pragma once

#include <algorithm>
#include <cmath>

#include "rig/contact.h"
#include "rig/settings.h"
#include "rig/speeds.h"

namespace wheel_twin::rig {

struct TestContact : Contact {
  double radius = 0.09;
  double stiffness = 4000.0;  // N/m of hub displacement
  double thrust = 0.5;        // thrust over normal load at slip 1
  double side = 0.8;          // side force over normal load at 1 rad
  double resistance = 1.0;    // N off the thrust while travelling
  bool again = true;
  HubMotion last;

  HubLoad advance(const HubMotion& motion) override {
    last = motion;
    const double normal = std::max(0.0, -stiffness * motion.position.z());
    HubLoad load;
    load.force_hub_rig.z() = normal;
    load.vertical_stiffness = normal > 0.0 ? stiffness : 0.0;
    const double rim = radius * motion.wheel_rate;
    if (normal > 0.0 && std::max(std::abs(rim), std::abs(motion.velocity.x())) > rest_speed) {
      const double slip = slip_ratio(motion.velocity.x(), rim);
      const double gross = thrust * slip * normal;
      load.force_hub_rig.x() = gross - resistance;
      load.force_hub_rig.y() = side * motion.steering_angle * normal;
      load.drive_torque = radius * gross;
      load.torque_hub_rig = -load.drive_torque * Eigen::Vector3d(-std::sin(motion.steering_angle),
                                                                 std::cos(motion.steering_angle), 0.0);
    }
    return load;
  }
  bool repeatable() const override { return again; }
};

/// A rig without lags, belt, friction or losses.
inline RigSettings plain_rig() {
  RigSettings settings;
  settings.carriage.speed_lag = 0.0;
  settings.drive.speed_lag = 0.0;
  settings.slide.viscous_damping = 0.0;
  settings.drive.inertia = 0.0;
  return settings;
}

}  // namespace wheel_twin::rig
