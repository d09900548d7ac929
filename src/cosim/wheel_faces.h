// The faces of a flexible wheel's rim segments as triangle meshes for the discrete-element soil: outer and
// inner face of the sheet, its two edges, and the grousers' plates. Neighbouring segments share their edges
// on the bisector of the joint in the undeformed wheel; bending opens or closes that seam by at most half the
// thickness times half the change of angle (0.2 mm times 0.02 at the loads of the paper), far below what the
// walls take for one place. Frame of a mesh: the segment's axes and reference point (wheel/flexible_wheel.h).
// SI units.
#pragma once

#include <vector>

#include "dem/walls.h"
#include "wheel/flexible_wheel.h"

namespace wheel_twin::cosim {

/// One mesh a segment. `shapes` in the order of the segments around the rim.
std::vector<dem::Mesh> wheel_faces(const std::vector<wheel::SegmentShape>& shapes);

std::vector<wheel::SegmentShape> segment_shapes(const wheel::FlexibleWheel& wheel);

/// From the axle to the outer face of the undeformed rim, without grousers, m.
double rim_radius(const wheel::FlexibleWheel& wheel);

/// Largest distance of any face from the axle of the undeformed wheel, m.
double outermost_radius(const wheel::FlexibleWheel& wheel);

}  // namespace wheel_twin::cosim
