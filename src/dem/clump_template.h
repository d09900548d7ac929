// Rigid clumps: 1 to 16 overlapping spheres, and the mass properties of the *union* of the spheres (overlap
// counts once). Two spheres in closed form (sphere segments), more by slicing: the cross-section of the union
// is a union of discs whose moments are line integrals over its boundary arcs (Green), integrated along z by
// Gauss-Legendre between the heights at which the arcs change. Body frame: origin at the centre of mass, axes
// principal. SI units.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "base/yaml.h"

namespace wheel_twin::dem {

struct ClumpSphere {
  Eigen::Vector3d center{0.0, 0.0, 0.0};  ///< m
  double radius = 0.0;                    ///< m
};

/// Moments of a body of unit density.
struct VolumeMoments {
  double volume = 0.0;                                ///< m^3
  Eigen::Vector3d centroid{0.0, 0.0, 0.0};            ///< m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centroid, m^5
};

/// Moments of the union of two spheres, closed form (any distance, one inside the other included).
VolumeMoments union_of_two(const ClumpSphere& a, const ClumpSphere& b);

/// Moments of the union of any number of spheres; `nodes` Gauss-Legendre nodes between two heights at which
/// the cross-section changes its shape. The error falls exponentially with the nodes; 24 reach 1e-10.
VolumeMoments union_by_slices(const std::vector<ClumpSphere>& spheres, int nodes = 24);

/// A clump shape of nominal size in its body frame. A clump of size factor s has centres and radii times s,
/// mass density * volume * s^3 and principal inertia density * inertia * s^5.
struct ClumpTemplate {
  static constexpr int maximum_spheres = 16;

  std::string name;
  std::vector<ClumpSphere> spheres;
  double volume = 0.0;                     ///< m^3
  Eigen::Vector3d inertia{0.0, 0.0, 0.0};  ///< principal, of unit density, m^5
  double bounding_radius = 0.0;            ///< m, about the centre of mass
};

/// Moves the spheres to the body frame and computes the mass properties. Throws Error, naming the clump, when
/// there is no sphere or more than 16, a radius is not positive, or the spheres do not hang together (each
/// must overlap the rest; touching in a point is not enough).
ClumpTemplate make_clump(const std::string& name, std::vector<ClumpSphere> spheres);

/// Shapes that appear together in a soil.
struct ClumpFamily {
  std::string name;
  std::vector<ClumpTemplate> shapes;
  std::vector<double> shares;  ///< fraction of the clumps of each shape, sum 1
  double smallest_size = 1.0;  ///< size factor is uniform between these two
  double largest_size = 1.0;

  double smallest_radius() const;  ///< of any sphere in the family, m
  double largest_bounding_radius() const;
  double mean_volume() const;   ///< of a clump, m^3, over shapes and sizes
  double mean_spheres() const;  ///< of a clump
};

/// Keys: name, sphere_radius (m, nominal), size_range [low, high] (factors), shapes: list of {name, share
/// (default equal), spheres: list of {center: [x, y, z], radius}} with centres and radii in nominal radii.
ClumpFamily read_clump_family(const yaml::Map& map);

}  // namespace wheel_twin::dem
