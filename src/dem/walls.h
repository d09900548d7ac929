// Rigid geometries that particles touch: half-spaces, surfaces of revolution (cylinder, funnel, disc) and
// triangle meshes (boxes, rim segments, grouser plates). Each wall is one rigid part with a prescribed pose
// and velocity and receives the force and torque of the particles on it. Walls of the same `surface` (the
// segments of a wheel) are one surface to the particles: a tangential spring passes from part to part, and an
// edge that two parts share counts once. Walls are seen from both sides except the half-space. SI units,
// world frame unless said otherwise.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace wheel_twin::dem {

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< of the part's reference point, m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< part to world
};

struct Motion {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< of the reference point, m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< world axes, rad/s
};

/// Solid half-space behind a plane through the part's origin; `normal` (part frame) points to the particles.
struct HalfSpace {
  Eigen::Vector3d normal{0.0, 0.0, 1.0};
};

/// The polyline `profile` of (radius, height) points, m, turned about the part's z axis. Two points of the
/// same radius are an open cylinder, of the same height an annulus or (radius 0) a disc; a cone and a tube
/// are a funnel.
struct Revolved {
  std::vector<Eigen::Vector2d> profile;
};

/// Triangles in the part frame.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Parallelogram with a corner and two edges.
Mesh parallelogram(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_1,
                   const Eigen::Vector3d& edge_2);
/// Six sides of a box.
Mesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high);
/// Appends `part` to `mesh`.
void append(Mesh& mesh, const Mesh& part);

struct Wall {
  std::string name;  ///< for messages
  std::uint32_t material = 0;
  std::variant<HalfSpace, Revolved, Mesh> shape;
  Pose pose;
  Motion motion;
  /// Parts with the same non-negative number are one surface; -1: a surface of its own.
  std::int32_t surface = -1;
};

/// What the particles exert on a part.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  ///< about the part's reference point, N m
};

}  // namespace wheel_twin::dem
