// A hard level floor for the wheel to stand and roll on: penalty springs and dampers at the outer corners of
// the rim plates and the tips of the grousers, Coulomb friction with a tangential spring that remembers where
// a corner touched down. For verification and for the hub's load-deflection curve; soil is the
// co-simulation's. Rig axes, SI units.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "wheel/flexible_wheel.h"

namespace wheel_twin::wheel {

struct FloorProperties {
  double height = 0.0;       ///< m
  double stiffness = 5.0e5;  ///< N/m a corner
  double damping = 0.0;      ///< N s/m a corner, while it presses
  double friction = 0.0;     ///< coefficient
};

class RigidFloor {
 public:
  RigidFloor(const FlexibleWheel& wheel, const FloorProperties& properties);
  /// Applies the floor's forces to the segments for a coming step of `dt` (s); returns their sum, N.
  Eigen::Vector3d press(FlexibleWheel& wheel, double dt);
  void set_height(double height) { properties_.height = height; }
  /// The lowest corner of the wheel, m, and the floor's overlap with it are the caller's measure of
  /// penetration.
  static double lowest_corner(const FlexibleWheel& wheel);

 private:
  struct Corner {
    int segment;
    double x, z;  // segment axes
    bool touches = false;
    double stretch = 0.0;  // of the tangential spring, m
  };
  FloorProperties properties_;
  std::vector<Corner> corners_;
};

}  // namespace wheel_twin::wheel
