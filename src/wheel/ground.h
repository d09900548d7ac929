// Hard ground for a wheel: a level floor, boxes, spheres and convex rocks, as a YAML file describes them
// (config/grounds), and how hard and rough they are. Rig axes (x along travel, z up), SI units.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml.h"

namespace wheel_twin::wheel {

/// Penalty contact: springs and dampers, and Coulomb friction with a spring along the wheel's heading that
/// sticks up to the limit. An edge of a plate that lies flat has two contact points at its ends.
struct ContactProperties {
  double stiffness = 5.0e5;  ///< N/m an edge of a plate
  double damping = 0.0;      ///< N s/m an edge, while it presses
  double friction = 0.0;     ///< coefficient
};

struct GroundBox {
  Eigen::Vector3d centre{0.0, 0.0, 0.0};  ///< m
  Eigen::Vector3d size{0.0, 0.0, 0.0};    ///< edges, m
  double pitch = 0.0;                     ///< rad about y: the end that lies ahead goes down
};

struct GroundSphere {
  Eigen::Vector3d centre{0.0, 0.0, 0.0};  ///< m
  double radius = 0.0;                    ///< m
};

/// The convex hull of its vertices; a hollow one is built of several.
struct GroundRock {
  std::vector<Eigen::Vector3d> vertices;      ///< m
  std::vector<std::array<int, 3>> triangles;  ///< of its surface, for pictures
};

struct Ground {
  std::string name = "floor";
  std::optional<double> floor = 0.0;  ///< height, m
  std::vector<GroundBox> boxes;
  std::vector<GroundSphere> spheres;
  std::vector<GroundRock> rocks;
  ContactProperties contact;
};

/// Reads a ground. Files of rocks (Wavefront OBJ, vertices and faces) are looked for beside the YAML file.
/// Throws Error naming file, line and key.
Ground read_ground(const yaml::Map& map);
Ground read_ground_file(const std::string& path);

/// Vertices and faces of a Wavefront OBJ file; faces of more than three corners are cut into fans. Throws
/// Error naming file and line.
GroundRock read_obj(const std::string& path);

}  // namespace wheel_twin::wheel
