#include "dem/reference_bed.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "dem/cloud.h"

namespace wheel_twin::dem {
namespace {

ClumpFamily family_of(const ReferenceBed& bed, const GranularSoil& soil) {
  if (bed.clumps) return soil.clumps;
  ClumpFamily family;
  family.name = "spheres";
  family.shapes = {make_clump("sphere", {{Eigen::Vector3d::Zero(), 3e-3}})};
  family.shares = {1.0};
  family.smallest_size = 0.9;
  family.largest_size = 1.1;
  return family;
}

std::size_t spheres_of_shape(const ClumpFamily& family) {
  return family.shapes.front().spheres.size();
}

constexpr double kCloudDensity = 0.2;
constexpr double kBedDepth = 0.1;  // m

/// Periodic box from the origin to `high`, `copies` times as wide, over a floor.
System make_world(const ReferenceBed& bed, const GranularSoil& soil, const Eigen::Vector3d& high,
                  const std::array<int, 2>& copies) {
  const ClumpFamily family = family_of(bed, soil);
  WorldSettings settings;
  settings.low = {0.0, 0.0, 0.0};
  settings.high = {copies[0] * high.x(), copies[1] * high.y(), high.z()};
  settings.periodic_x = settings.periodic_y = true;
  settings.time_step = bed.time_step;
  settings.smallest_size = family.smallest_size;
  settings.threads = bed.threads;
  settings.sleep = bed.sleep;
  System system(settings, soil.materials(), family.shapes);
  Wall ground;
  ground.name = "floor";
  ground.material = GranularSoil::wall_material;
  ground.shape = HalfSpace{};
  system.add_wall(ground);
  return system;
}

}  // namespace

System make_reference_world(const ReferenceBed& bed, const GranularSoil& soil) {
  const ClumpFamily family = family_of(bed, soil);
  const double grains = static_cast<double>(bed.spheres / spheres_of_shape(family)) * family.mean_volume();
  const double area = grains / (0.55 * kBedDepth);
  return make_world(
      bed, soil,
      {std::sqrt(2.2 * area), std::sqrt(area / 2.2), 1.05 * grains / (area * kCloudDensity) + 0.05}, {1, 1});
}

void settle_reference_bed(System& system, const ReferenceBed& bed, const GranularSoil& soil,
                          const std::function<void(double)>& progress) {
  const ClumpFamily family = family_of(bed, soil);
  Random random(1);
  CloudRegion region;
  region.low = system.settings().low;
  region.high = system.settings().high;
  region.high.z() -= 0.02;
  region.periodic_x = region.periodic_y = true;
  std::vector<Particle> cloud = random_cloud(family, region, bed.spheres / spheres_of_shape(family), random,
                                             GranularSoil::grain_material);
  // Every grain starts with the speed that brings the cloud down evenly.
  for (auto& particle : cloud) particle.velocity.z() = -particle.position.z() / 0.2;
  system.add(cloud);
  const int rounds = 100;
  const int steps = static_cast<int>(0.5 / system.time_step()) / rounds;
  double kinetic = 1.0;
  for (int round = 0; round < 10 * rounds; ++round) {
    system.step(steps);
    progress(std::min(0.99, static_cast<double>(round) / rounds));
    if (round < rounds / 2) continue;
    double mass = 0.0;
    for (std::size_t k = 0; k < system.size(); ++k) mass += system.mass(k);
    kinetic = system.energy().kinetic;
    if (kinetic < 0.5 * mass * 1e-3 * 1e-3) break;
  }
  progress(1.0);
}

System tiled_reference_bed(const System& settled, const ReferenceBed& bed, const GranularSoil& soil,
                           int across_x, int across_y) {
  const std::array<int, 2> copies{across_x, across_y};
  const Eigen::Vector3d low = settled.settings().low;
  const Eigen::Vector3d extent = settled.settings().high - low;
  System system = make_world(bed, soil, settled.settings().high, copies);
  const State one = settled.state();
  const std::vector<SphereState> spheres = settled.spheres();
  const auto sphere_count = static_cast<std::uint32_t>(spheres.size());
  const auto tile = [&](int i, int j) {
    return static_cast<std::uint32_t>((i + across_x) % across_x * across_y + (j + across_y) % across_y);
  };
  const auto repeat = [&](auto& all, const auto& column) {
    all.insert(all.end(), column.begin(), column.end());
  };
  State state = one;
  for (int copy = 1; copy < across_x * across_y; ++copy) {
    repeat(state.shape, one.shape);
    repeat(state.material, one.material);
    repeat(state.size, one.size);
    repeat(state.stiffness, one.stiffness);
    repeat(state.velocity, one.velocity);
    repeat(state.angular_momentum, one.angular_momentum);
    repeat(state.orientation, one.orientation);
    repeat(state.load, one.load);
  }
  state.position.clear();
  state.contacts.clear();
  state.wall_contacts.clear();
  for (int i = 0; i < across_x; ++i) {
    for (int j = 0; j < across_y; ++j) {
      const std::uint32_t here = tile(i, j) * sphere_count;
      for (const auto& p : one.position)
        state.position.emplace_back(p.x() + i * extent.x(), p.y() + j * extent.y(), p.z());
      for (ContactHistory h : one.contacts) {
        // The image of b that a touches may be that of the next copy.
        const Eigen::Vector3d between = spheres[h.b].center - spheres[h.a].center;
        const int di = static_cast<int>(std::lround(between.x() / extent.x()));
        const int dj = static_cast<int>(std::lround(between.y() / extent.y()));
        h.a += here;
        h.b += tile(i - di, j - dj) * sphere_count;
        if (h.a > h.b) {
          std::swap(h.a, h.b);
          for (int k = 0; k < 3; ++k) {
            h.shear[k] = -h.shear[k];
            h.rolling[k] = -h.rolling[k];
          }
        }
        state.contacts.push_back(h);
      }
      for (ContactHistory h : one.wall_contacts) {
        h.a += here;
        state.wall_contacts.push_back(h);
      }
    }
  }
  system.restore(state);
  return system;
}

std::string lammps_data(const System& system) {
  const auto spheres = system.spheres();
  const WorldSettings& settings = system.settings();
  const double density = system.materials()[GranularSoil::grain_material].density;
  double top = 0.0;
  for (const auto& sphere : spheres) top = std::max(top, sphere.center.z() + sphere.radius);
  std::string text = fmt::format(
      "settled bed\n\n{} atoms\n1 atom types\n{:.17g} {:.17g} xlo xhi\n{:.17g} {:.17g} ylo yhi\n{:.17g} "
      "{:.17g} zlo "
      "zhi\n\nAtoms # hybrid\n\n",
      spheres.size(), settings.low.x(), settings.high.x(), settings.low.y(), settings.high.y(), -0.001,
      top + 0.01);
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const auto& s = spheres[k];
    fmt::format_to(std::back_inserter(text), "{} 1 {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {}\n", k + 1,
                   s.center.x(), s.center.y(), s.center.z(), 2.0 * s.radius, density, s.particle + 1);
  }
  return text;
}

}  // namespace wheel_twin::dem
