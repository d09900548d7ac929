#include "wheel/rigid_floor.h"

#include <algorithm>
#include <limits>

namespace wheel_twin::wheel {

using Eigen::Vector3d;

RigidFloor::RigidFloor(const FlexibleWheel& wheel, const FloorProperties& properties)
    : properties_(properties) {
  for (int i = 0; i < wheel.segment_count(); ++i) {
    for (const Box& box : wheel.shape(i).boxes) {
      for (const double side : {-1.0, 1.0}) {
        corners_.push_back(
            {i, box.centre.x() + side * box.half_extents.x(), box.centre.z() + box.half_extents.z()});
      }
    }
  }
}

Vector3d RigidFloor::press(FlexibleWheel& wheel, double dt) {
  Vector3d total = Vector3d::Zero();
  SegmentState state;
  int current = -1;
  Vector3d tangent = Vector3d::Zero();
  Vector3d outward = Vector3d::Zero();
  for (Corner& corner : corners_) {
    if (corner.segment != current) {
      current = corner.segment;
      state = wheel.segment(current);
      tangent = state.orientation * Vector3d::UnitX();
      outward = state.orientation * Vector3d::UnitZ();
    }
    const Vector3d arm = corner.x * tangent + corner.z * outward;
    const double overlap = properties_.height - (state.position.z() + arm.z());
    if (overlap <= 0.0) {
      corner.touches = false;
      continue;
    }
    const Vector3d velocity = state.velocity + state.angular_velocity.cross(arm);
    const double normal = std::max(0.0, properties_.stiffness * overlap - properties_.damping * velocity.z());
    // The wheel's heading: the floor resists along it; across it the wheel is guided by its hub.
    const Vector3d axle = state.orientation * Vector3d::UnitY();
    const Vector3d heading = axle.cross(Vector3d::UnitZ());
    if (!corner.touches) {
      corner.touches = true;
      corner.stretch = 0.0;
    }
    corner.stretch += dt * velocity.dot(heading);
    const double limit = properties_.friction * normal;
    const double wanted = properties_.stiffness * corner.stretch;
    const double friction = std::clamp(wanted, -limit, limit);
    if (friction != wanted) corner.stretch = friction / properties_.stiffness;
    const Vector3d force = normal * Vector3d::UnitZ() - friction * heading;
    wheel.apply(corner.segment, force, arm.cross(force));
    total += force;
  }
  return total;
}

double RigidFloor::lowest_corner(const FlexibleWheel& wheel) {
  double lowest = std::numeric_limits<double>::max();
  for (int i = 0; i < wheel.segment_count(); ++i) {
    const SegmentState state = wheel.segment(i);
    for (const Box& box : wheel.shape(i).boxes) {
      for (const double side : {-1.0, 1.0}) {
        const Vector3d corner{box.centre.x() + side * box.half_extents.x(), 0.0,
                              box.centre.z() + box.half_extents.z()};
        lowest = std::min(lowest, (state.position + state.orientation * corner).z());
      }
    }
  }
  return lowest;
}

}  // namespace wheel_twin::wheel
