#include "dem/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace wheel_twin::dem {
namespace {

// Halton sequence: points that fill space evenly.
double halton(int index, int base) {
  double result = 0.0;
  for (double f = 1.0 / base; index > 0; index /= base, f /= base) result += f * (index % base);
  return result;
}

constexpr int points_per_clump = 128;

// Points spread evenly over the union of a template's spheres, body frame.
std::vector<Eigen::Vector3d> points_inside(const ClumpTemplate& shape) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 1; static_cast<int>(points.size()) < points_per_clump; ++i) {
    const Eigen::Vector3d p =
        shape.bounding_radius *
        Eigen::Vector3d(2 * halton(i, 2) - 1, 2 * halton(i, 3) - 1, 2 * halton(i, 5) - 1);
    for (const ClumpSphere& sphere : shape.spheres)
      if ((p - sphere.center).squaredNorm() < sphere.radius * sphere.radius) {
        points.push_back(p);
        break;
      }
  }
  return points;
}

// Periodic sides need no test: every clump is inside.
bool is_inside(const System& system, const Box& region, const Eigen::Vector3d& p) {
  const WorldSettings& s = system.settings();
  const bool whole_x = s.periodic_x && region.low.x() <= s.low.x() && region.high.x() >= s.high.x();
  const bool whole_y = s.periodic_y && region.low.y() <= s.low.y() && region.high.y() >= s.high.y();
  return (whole_x || (p.x() >= region.low.x() && p.x() < region.high.x())) &&
         (whole_y || (p.y() >= region.low.y() && p.y() < region.high.y())) && p.z() >= region.low.z() &&
         p.z() < region.high.z();
}

}  // namespace

std::vector<double> layer_densities(const System& system, const Box& region, double thickness) {
  std::vector<std::vector<Eigen::Vector3d>> points;
  for (const ClumpTemplate& shape : system.templates()) points.push_back(points_inside(shape));
  const Eigen::Vector3d size = region.high - region.low;
  const int layers = std::max(1, static_cast<int>(std::lround(size.z() / thickness)));
  std::vector<double> volume(layers, 0.0);
  for (const Particle& particle : system.particles()) {
    const ClumpTemplate& shape = system.templates()[particle.shape];
    const double share = shape.volume * std::pow(particle.size, 3) / points_per_clump;
    const Eigen::Matrix3d turn = particle.size * particle.orientation.toRotationMatrix();
    for (const Eigen::Vector3d& point : points[particle.shape]) {
      const Eigen::Vector3d p = particle.position + turn * point;
      if (!is_inside(system, region, p)) continue;
      volume[std::min(layers - 1, static_cast<int>((p.z() - region.low.z()) / size.z() * layers))] += share;
    }
  }
  for (double& v : volume) v /= size.x() * size.y() * size.z() / layers;
  return volume;
}

double packing_density(const System& system, const Box& region) {
  return layer_densities(system, region, region.high.z() - region.low.z())[0];
}

HeightMap height_map(const std::vector<SphereState>& spheres, const Box& region, double spacing) {
  HeightMap map;
  map.spacing = spacing;
  map.x = region.low.x() + 0.5 * spacing;
  map.y = region.low.y() + 0.5 * spacing;
  map.columns = std::max(1, static_cast<int>((region.high.x() - region.low.x()) / spacing + 1e-9));
  map.rows = std::max(1, static_cast<int>((region.high.y() - region.low.y()) / spacing + 1e-9));
  map.height.assign(static_cast<std::size_t>(map.columns) * map.rows,
                    std::numeric_limits<double>::quiet_NaN());
  for (const SphereState& s : spheres) {
    const int first_column =
        std::max(0, static_cast<int>(std::ceil((s.center.x() - s.radius - map.x) / spacing)));
    const int last_column =
        std::min(map.columns - 1, static_cast<int>(std::floor((s.center.x() + s.radius - map.x) / spacing)));
    const int first_row =
        std::max(0, static_cast<int>(std::ceil((s.center.y() - s.radius - map.y) / spacing)));
    const int last_row =
        std::min(map.rows - 1, static_cast<int>(std::floor((s.center.y() + s.radius - map.y) / spacing)));
    for (int row = first_row; row <= last_row; ++row)
      for (int column = first_column; column <= last_column; ++column) {
        const double dx = map.x + column * spacing - s.center.x();
        const double dy = map.y + row * spacing - s.center.y();
        const double squared = s.radius * s.radius - dx * dx - dy * dy;
        if (squared < 0.0) continue;
        double& height = map.height[static_cast<std::size_t>(row) * map.columns + column];
        const double z = s.center.z() + std::sqrt(squared);
        if (!(height >= z)) height = z;
      }
  }
  return map;
}

double mean_height(const HeightMap& map) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const double h : map.height)
    if (std::isfinite(h)) {
      sum += h;
      ++count;
    }
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

Coordination coordination(const System& system, const Box& region) {
  const std::vector<SphereState> spheres = system.spheres();
  std::vector<bool> counts(system.size());
  std::size_t clumps = 0;
  const std::vector<Particle> particles = system.particles();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    counts[i] = is_inside(system, region, particles[i].position);
    clumps += counts[i];
  }
  std::size_t sphere_total = 0;
  for (const SphereState& s : spheres) sphere_total += counts[s.particle];
  std::size_t contact_ends = 0;
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const ContactForce& c : system.contacts()) {
    const std::uint32_t a = spheres[c.sphere_a].particle;
    const std::uint32_t b = spheres[c.sphere_b].particle;
    contact_ends += counts[a] + counts[b];
    pairs.insert(std::minmax(a, b));
  }
  std::size_t neighbours = 0;
  for (const auto& [a, b] : pairs) neighbours += counts[a] + counts[b];
  Coordination result;
  if (clumps > 0) result.per_clump = static_cast<double>(neighbours) / static_cast<double>(clumps);
  if (sphere_total > 0)
    result.per_sphere = static_cast<double>(contact_ends) / static_cast<double>(sphere_total);
  return result;
}

}  // namespace wheel_twin::dem
