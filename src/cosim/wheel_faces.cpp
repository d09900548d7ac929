#include "cosim/wheel_faces.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace wheel_twin::cosim {
namespace {

using Eigen::Vector3d;

/// A quadrilateral as two triangles; corners in order.
void add_quad(dem::Mesh& mesh, const std::array<Vector3d, 4>& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

/// The sheet between two joints, whose ends lie on the bisectors: `slant` is the tangent of half the angle
/// between neighbours.
dem::Mesh sheet(const wheel::Box& plate, double slant) {
  const auto corner = [&](double x, double y, double z) {
    const double height = z * plate.half_extents.z();
    return Vector3d(x * (plate.half_extents.x() + slant * height), y * plate.half_extents.y(), height);
  };
  dem::Mesh mesh;
  for (const double side : {1.0, -1.0}) {
    add_quad(mesh, {corner(-1.0, -1.0, side), corner(1.0, -1.0, side), corner(1.0, 1.0, side),
                    corner(-1.0, 1.0, side)});
  }
  for (const double side : {1.0, -1.0}) {
    add_quad(mesh, {corner(-1.0, side, -1.0), corner(1.0, side, -1.0), corner(1.0, side, 1.0),
                    corner(-1.0, side, 1.0)});
  }
  return mesh;
}

/// A plate that stands on the rim: all sides but the foot.
void add_grouser(dem::Mesh& mesh, const wheel::Box& box) {
  const auto corner = [&](double x, double y, double z) {
    return Vector3d(box.centre + Vector3d(x, y, z).cwiseProduct(box.half_extents));
  };
  add_quad(mesh, {corner(-1, -1, 1), corner(1, -1, 1), corner(1, 1, 1), corner(-1, 1, 1)});
  for (const double side : {1.0, -1.0}) {
    add_quad(mesh, {corner(side, -1, -1), corner(side, 1, -1), corner(side, 1, 1), corner(side, -1, 1)});
    add_quad(mesh, {corner(-1, side, -1), corner(1, side, -1), corner(1, side, 1), corner(-1, side, 1)});
  }
}

}  // namespace

std::vector<dem::Mesh> wheel_faces(const std::vector<wheel::SegmentShape>& shapes) {
  const double slant = std::tan(M_PI / static_cast<double>(shapes.size()));
  std::vector<dem::Mesh> meshes;
  for (const wheel::SegmentShape& shape : shapes) {
    dem::Mesh mesh = sheet(shape.boxes.front(), slant);
    for (std::size_t b = 1; b < shape.boxes.size(); ++b) add_grouser(mesh, shape.boxes[b]);
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

std::vector<wheel::SegmentShape> segment_shapes(const wheel::FlexibleWheel& wheel) {
  std::vector<wheel::SegmentShape> shapes;
  for (int i = 0; i < wheel.segment_count(); ++i) shapes.push_back(wheel.shape(i));
  return shapes;
}

double rim_radius(const wheel::FlexibleWheel& wheel) {
  return wheel.model().radius + wheel.shape(0).boxes.front().half_extents.z();
}

double outermost_radius(const wheel::FlexibleWheel& wheel) {
  const double apothem = wheel.model().radius * std::cos(M_PI / wheel.segment_count());
  double radius = 0.0;
  for (int i = 0; i < wheel.segment_count(); ++i) {
    for (const wheel::Box& box : wheel.shape(i).boxes) {
      const double along = std::abs(box.centre.x()) + box.half_extents.x();
      radius = std::max(radius, std::hypot(apothem + box.centre.z() + box.half_extents.z(), along));
    }
  }
  return radius;
}

}  // namespace wheel_twin::cosim
