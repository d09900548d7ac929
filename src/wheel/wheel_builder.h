// From a wheel's description to bodies, joints and springs in its plane. Bodies: the rim's segments first, in
// the order of their angle from the top, then the beams' bodies from the hub outward. SI units.
#pragma once

#include <vector>

#include "wheel/flexible_wheel.h"
#include "wheel/planar_system.h"

namespace wheel_twin::wheel {

/// A spring or beam of the model within the system.
struct BuiltBeam {
  int position = 0;
  int set = 0;
  int spring = -1;       ///< of the system; -1 for a beam
  int first_body = -1;   ///< of the beam
  int first_joint = -1;  ///< the clamp at the hub; bodies + 1 joints follow each other
  double angle = 0.0;    ///< around the hub
};

struct BuiltSegment {
  double angle = 0.0;     ///< around the hub, undeformed
  Vec2 reference;         ///< middle of the rim plate from the centre of mass, segment axes
  Vec2 reference_on_hub;  ///< the same point in hub axes, undeformed
  SegmentShape shape;
};

struct BuiltWheel {
  PlanarSystem::Parts parts;
  std::vector<BuiltSegment> segments;
  std::vector<BuiltBeam> beams;
  double rim_mass = 0.0;
  double rim_inertia = 0.0;  ///< about the axle, undeformed
};

BuiltWheel build(const WheelModel& model);

}  // namespace wheel_twin::wheel
