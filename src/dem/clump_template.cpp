#include "dem/clump_template.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

// A connected clump is one whose spheres, joined where they overlap, form one piece.
bool is_connected(const std::vector<ClumpSphere>& spheres) {
  std::vector<bool> reached(spheres.size(), false);
  std::vector<std::size_t> open{0};
  reached[0] = true;
  while (!open.empty()) {
    const ClumpSphere& from = spheres[open.back()];
    open.pop_back();
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      if (reached[i] || (spheres[i].center - from.center).norm() >= spheres[i].radius + from.radius) continue;
      reached[i] = true;
      open.push_back(i);
    }
  }
  return std::all_of(reached.begin(), reached.end(), [](bool r) { return r; });
}

}  // namespace

ClumpTemplate make_clump(const std::string& name, std::vector<ClumpSphere> spheres) {
  if (spheres.empty()) throw Error(fmt::format("clump '{}': has no sphere", name));
  if (spheres.size() > ClumpTemplate::maximum_spheres)
    throw Error(fmt::format("clump '{}': has {} spheres, at most {} are possible", name, spheres.size(),
                            int{ClumpTemplate::maximum_spheres}));
  for (const ClumpSphere& sphere : spheres)
    if (!(sphere.radius > 0.0) || !std::isfinite(sphere.radius) || !sphere.center.allFinite())
      throw Error(fmt::format("clump '{}': a sphere needs a positive radius and a finite centre", name));
  if (!is_connected(spheres))
    throw Error(
        fmt::format("clump '{}': its spheres are not connected: every sphere must overlap the rest", name));

  VolumeMoments moments;
  if (spheres.size() == 1)
    moments = union_of_two(spheres[0], spheres[0]);
  else if (spheres.size() == 2)
    moments = union_of_two(spheres[0], spheres[1]);
  else
    moments = union_by_slices(spheres);

  ClumpTemplate clump;
  clump.name = name;
  clump.volume = moments.volume;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments.inertia);
  clump.inertia = solver.eigenvalues();
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  for (ClumpSphere& sphere : spheres) {
    sphere.center = axes.transpose() * (sphere.center - moments.centroid);
    clump.bounding_radius = std::max(clump.bounding_radius, sphere.center.norm() + sphere.radius);
  }
  clump.spheres = std::move(spheres);
  return clump;
}

double ClumpFamily::smallest_radius() const {
  double radius = std::numeric_limits<double>::infinity();
  for (const ClumpTemplate& shape : shapes)
    for (const ClumpSphere& sphere : shape.spheres) radius = std::min(radius, sphere.radius);
  return radius * smallest_size;
}

double ClumpFamily::largest_bounding_radius() const {
  double radius = 0.0;
  for (const ClumpTemplate& shape : shapes) radius = std::max(radius, shape.bounding_radius);
  return radius * largest_size;
}

double ClumpFamily::mean_spheres() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    sum += shares[i] * static_cast<double>(shapes[i].spheres.size());
  return sum;
}

double ClumpFamily::mean_volume() const {
  // Mean of s^3 over a uniform s in [a, b] is (a + b)(a^2 + b^2)/4.
  const double a = smallest_size;
  const double b = largest_size;
  double volume = 0.0;
  for (std::size_t i = 0; i < shapes.size(); ++i) volume += shares[i] * shapes[i].volume;
  return volume * (a + b) * (a * a + b * b) / 4.0;
}

ClumpFamily read_clump_family(const yaml::Map& map) {
  ClumpFamily family;
  family.name = map.text("name");
  const double nominal = map.number("sphere_radius", {1e-7, 1.0});
  const std::vector<double> sizes = map.numbers("size_range", {1e-3, 1e3});
  if (sizes.size() != 2 || sizes[0] > sizes[1]) map.fail("size_range", "two factors, the smaller one first");
  family.smallest_size = sizes[0];
  family.largest_size = sizes[1];
  const yaml::List shapes = map.list("shapes");
  if (shapes.size() == 0) map.fail("shapes", "at least one shape is needed");
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const yaml::Map shape = shapes.map(i);
    const std::string name = shape.text("name");
    family.shares.push_back(shape.number_or("share", 1.0, yaml::positive()));
    const yaml::List spheres = shape.list("spheres");
    std::vector<ClumpSphere> list(spheres.size());
    for (std::size_t k = 0; k < list.size(); ++k) {
      const yaml::Map sphere = spheres.map(k);
      const std::vector<double> center = sphere.numbers("center");
      if (center.size() != 3) sphere.fail("center", "three coordinates are expected");
      list[k].center = nominal * Eigen::Vector3d(center[0], center[1], center[2]);
      list[k].radius = nominal * sphere.number("radius", yaml::positive());
      sphere.finish();
    }
    shape.finish();
    try {
      family.shapes.push_back(make_clump(name, std::move(list)));
    } catch (const Error& error) {
      map.fail("shapes", error.what());
    }
  }
  const double sum = std::accumulate(family.shares.begin(), family.shares.end(), 0.0);
  for (double& share : family.shares) share /= sum;
  map.finish();
  return family;
}

}  // namespace wheel_twin::dem
