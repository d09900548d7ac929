// The one interface between a rig and what carries its wheel: semi-empirical contact or the co-simulation of
// discrete-element soil and multibody wheel. Everything above works with both.
// Frame `rig`: x along travel, y to the left, z up, z = 0 at the undisturbed soil.
#pragma once

#include <Eigen/Core>

namespace wheel_twin::rig {

/// The hub as the rig moves it: true motion, after everything that acts on the rig (`RigPort`).
struct HubMotion {
  double time = 0.0;                        ///< s
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< m, x from the start of the run, z is -(hub displacement)
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< m/s
  double wheel_angle = 0.0;                 ///< rad, positive rolling towards +x
  double wheel_rate = 0.0;                  ///< rad/s
  double steering_angle = 0.0;              ///< rad, wheel turned to the left when positive
};

/// What soil and wheel exert on the hub. The wheel has no weight here: the dead weight of the rig holds it.
struct HubLoad {
  Eigen::Vector3d force_hub_rig{0.0, 0.0, 0.0};  ///< on the hub, in rig axes, N
  /// About the hub centre, in rig axes, N m. Its part along the axle (-sin steering, cos steering, 0) is
  /// -drive_torque.
  Eigen::Vector3d torque_hub_rig{0.0, 0.0, 0.0};
  double drive_torque = 0.0;        ///< torque the drive must supply to the wheel, N m, positive driving
  double vertical_stiffness = 0.0;  ///< -d(force z)/d(position z), N/m; for implicit integration
};

class Contact {
 public:
  virtual ~Contact() = default;
  /// Advances soil and wheel to `motion.time`. Times increase from call to call; a repeated time is allowed
  /// where `repeatable` says so. A wheel above the soil gives zeros. A wheel that neither rolls nor travels
  /// carries the vertical force alone. Throws Error when the physics breaks.
  virtual HubLoad advance(const HubMotion& motion) = 0;
  /// Whether a call with the time of the last call evaluates that instant anew for another pose. Static
  /// equilibrium, quasi-static replay and towed wheels at coarse steps need it.
  virtual bool repeatable() const { return false; }
};

}  // namespace wheel_twin::rig
