// Hard ground of any shape under a flexible wheel: which plates and grousers touch it, where, how deep and in
// which direction, comes from Bullet's collision detection (double precision: bounding-volume tree, clipping
// of boxes and hulls, GJK/EPA); the forces are the penalty springs of ContactProperties. On a level
// floor alone, RigidFloor gives the same at a fraction of the cost. Rig axes, SI units.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "wheel/flexible_wheel.h"
#include "wheel/ground.h"

namespace wheel_twin::wheel {

struct GroundContact {
  int segment = 0;
  Eigen::Vector3d point{0.0, 0.0, 0.0};   ///< m
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  ///< from the ground to the wheel
  double overlap = 0.0;                   ///< m
  Eigen::Vector3d force{0.0, 0.0, 0.0};   ///< on the wheel, N
};

class RigidGround {
 public:
  RigidGround(const FlexibleWheel& wheel, const Ground& ground);
  ~RigidGround();
  RigidGround(RigidGround&&) noexcept;
  RigidGround& operator=(RigidGround&&) noexcept;

  /// Applies the ground's forces to the segments for a coming step of `dt` (s); returns their sum, N.
  Eigen::Vector3d press(FlexibleWheel& wheel, double dt);
  const std::vector<GroundContact>& contacts() const;  ///< of the last press()
  const Ground& ground() const;

  /// Hub height (m) at which the wheel, as it is now, just touches the ground when it comes from above at the
  /// hub's x and y; to 1 um. Throws Error when there is nothing below.
  static double touching_height(const FlexibleWheel& wheel, const Ground& ground);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::wheel
