#include "dem/walls.h"

namespace wheel_twin::dem {

Mesh parallelogram(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_1,
                   const Eigen::Vector3d& edge_2) {
  return {{corner, corner + edge_1, corner + edge_1 + edge_2, corner + edge_2}, {{0, 1, 2}, {0, 2, 3}}};
}

void append(Mesh& mesh, const Mesh& part) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const auto& t : part.triangles)
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

Mesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Vector3d size = high - low;
  const Eigen::Vector3d ex{size.x(), 0.0, 0.0};
  const Eigen::Vector3d ey{0.0, size.y(), 0.0};
  const Eigen::Vector3d ez{0.0, 0.0, size.z()};
  Mesh mesh = parallelogram(low, ex, ey);
  append(mesh, parallelogram(low + ez, ex, ey));
  append(mesh, parallelogram(low, ex, ez));
  append(mesh, parallelogram(low + ey, ex, ez));
  append(mesh, parallelogram(low, ey, ez));
  append(mesh, parallelogram(low + ex, ey, ez));
  return mesh;
}

}  // namespace wheel_twin::dem
