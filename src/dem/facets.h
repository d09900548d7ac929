// Closest points on the faces of walls: half-space, turned line (cone, cylinder, ring), triangle (Ericson,
// Real-Time Collision Detection, 2005, Section 5.1.5).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "dem/walls.h"

namespace wheel_twin::dem {

struct ClosestPoint {
  Eigen::Vector3d point;   ///< on the face, world, m
  Eigen::Vector3d normal;  ///< unit, from the face to the query point
  double distance;         ///< m, negative behind a half-space
};

/// One face of a wall in world coordinates.
struct Facet {
  enum class Kind : std::uint8_t { kHalfSpace, kTriangle, kRing } kind = Kind::kHalfSpace;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a,
                  c = a;  ///< triangle: corners; half-space: point, normal; ring: origin, axis, (unused)
  double r0 = 0.0, h0 = 0.0, r1 = 0.0, h1 = 0.0;  ///< ring: radius and height of the line's ends
};

ClosestPoint closest_point(const Facet& facet, const Eigen::Vector3d& p);

/// Faces of `wall` at its pose. Throws Error naming the wall when the shape has no faces or a degenerate one.
std::vector<Facet> make_facets(const Wall& wall);
/// Moves `facets` to the pose of `wall`; the same number and kind of faces.
void place_facets(const Wall& wall, std::vector<Facet>& facets);

/// Axis-aligned box of a facet; infinite for a half-space.
void bounds_of(const Facet& facet, Eigen::Vector3d& low, Eigen::Vector3d& high);

}  // namespace wheel_twin::dem
