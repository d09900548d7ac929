// The one interface between a rig and what carries its wheel: semi-empirical contact or the co-simulation of
// discrete-element soil and multibody wheel. Everything above works with both.
// Frame `rig`: x along travel, y to the left, z up, z = 0 at the undisturbed soil.
#pragma once

#include <Eigen/Core>

namespace wheel_twin::rig {

/// The hub as the rig moves it.
struct HubMotion {
  double time = 0.0;                        ///< s
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< m, z is -(hub displacement): 0 at first touch
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< m/s
  double wheel_angle = 0.0;                 ///< rad, positive rolling towards +x
  double wheel_rate = 0.0;                  ///< rad/s
  double steering_angle = 0.0;              ///< rad, wheel turned to the left when positive
};

/// What soil and wheel exert on the hub.
struct HubLoad {
  Eigen::Vector3d force_hub_rig{0.0, 0.0, 0.0};   ///< on the hub, in rig axes, N
  Eigen::Vector3d torque_hub_rig{0.0, 0.0, 0.0};  ///< about the hub centre, in rig axes, N m
  double drive_torque = 0.0;        ///< torque the drive must supply to the wheel, N m, positive driving
  double vertical_stiffness = 0.0;  ///< -d(force z)/d(position z), N/m; for implicit integration
};

class Contact {
 public:
  virtual ~Contact() = default;
  /// Advances soil and wheel to `motion.time`. Times increase from call to call. Throws Error when the
  /// physics breaks.
  virtual HubLoad advance(const HubMotion& motion) = 0;
};

}  // namespace wheel_twin::rig
