// The same clouds of clumps settled here and in LAMMPS: height, coordination number, floor pressure. The
// motion of a settling packing is chaotic, so single contacts differ; means over three seeds must agree
// within what seeds scatter.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include "base/random.h"
#include "dem/cloud.h"
#include "dem/measures.h"
#include "lammps.h"

namespace wheel_twin::dem {
namespace {

constexpr double width = 0.05;
constexpr double depth = 0.06;
constexpr double duration = 0.35;  // s: at rest after 0.25 s
constexpr int seeds = 6;

struct Settled {
  double height = 0.0;          // m
  double coordination = 0.0;    // contacts of a sphere
  double floor_pressure = 0.0;  // Pa
};

struct Spread {
  double mean = 0.0, variance = 0.0;
};

Spread spread(const std::vector<double>& values) {
  Spread s;
  for (const double v : values) s.mean += v / static_cast<double>(values.size());
  for (const double v : values)
    s.variance += (v - s.mean) * (v - s.mean) / static_cast<double>(values.size() - 1);
  return s;
}

// Difference of two means of three against the 95 % point of Student's t with four degrees of freedom
// (2.776).
void expect_same(const char* what, const std::vector<double>& ours, const std::vector<double>& theirs,
                 double floor) {
  const Spread a = spread(ours);
  const Spread b = spread(theirs);
  const double allowed = std::max(2.776 * std::sqrt((a.variance + b.variance) / seeds), floor * a.mean);
  EXPECT_NEAR(a.mean, b.mean, allowed) << what;
  testing::Test::RecordProperty(std::string(what) + "_ours", std::to_string(a.mean));
  testing::Test::RecordProperty(std::string(what) + "_lammps", std::to_string(b.mean));
  std::printf("%s: ours %.6g, LAMMPS %.6g, allowed difference %.2g\n", what, a.mean, b.mean, allowed);
}

TEST(LammpsBed, HeightCoordinationAndFloorPressureAgree) {
  if (std::system("command -v lmp > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "lmp (package lammps) is not installed";
  const GranularSoil soil = load_granular_soil("mars_simulant");
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("lammps_bed_" + std::to_string(getpid()));
  std::vector<double> height[2], coordination_number[2], floor_pressure[2];
  for (int seed = 1; seed <= seeds; ++seed) {
    BedSettings settings;
    settings.length = settings.width = width;
    settings.depth = depth;
    const auto count = static_cast<std::size_t>(0.55 * width * width * depth / soil.clumps.mean_volume());
    const double cloud = static_cast<double>(count) * soil.clumps.mean_volume() / (width * width * 0.22);
    CloudRegion region;
    region.low = {0.0, -0.5 * width, -depth};
    region.high = {width, 0.5 * width, cloud - depth};
    region.periodic_x = region.periodic_y = true;
    Random random(static_cast<std::uint64_t>(seed));
    const std::vector<Particle> particles =
        random_cloud(soil.clumps, region, count, random, GranularSoil::grain_material);

    System system = bed_world(soil, settings, cloud - depth + 0.01, 1);
    system.add(particles);
    const auto steps = static_cast<int>(duration / system.time_step());
    system.step(steps);

    lammps::Setup setup;
    setup.low = {0.0, -0.5 * width, -depth - 0.01};
    setup.high = {width, 0.5 * width, cloud - depth + 0.01};
    setup.floor = -depth;
    setup.friction = soil.grain_grain.friction;
    setup.time_step = system.time_step();
    setup.steps = steps;
    const std::string run_folder = (folder / std::to_string(seed)).string();
    std::filesystem::create_directories(run_folder);
    lammps::write(run_folder, soil, particles, setup);
    lammps::Result peer = lammps::run(run_folder);
    for (SphereState& s : peer.spheres) s.center.x() -= width * std::floor(s.center.x() / width);
    for (SphereState& s : peer.spheres) s.center.y() -= width * std::round(s.center.y() / width);

    const Box region_of_surface{{0.0, -0.5 * width, -depth}, {width, 0.5 * width, 1.0}};
    std::vector<SphereState> ours = system.spheres();
    for (SphereState& s : ours) s.center.x() -= width * std::floor(s.center.x() / width);
    for (SphereState& s : ours) s.center.y() -= width * std::round(s.center.y() / width);
    height[0].push_back(mean_height(height_map(ours, region_of_surface, 0.001)) + depth);
    height[1].push_back(mean_height(height_map(peer.spheres, region_of_surface, 0.001)) + depth);
    coordination_number[0].push_back(2.0 * static_cast<double>(system.contacts().size()) /
                                     static_cast<double>(system.sphere_count()));
    coordination_number[1].push_back(2.0 * peer.contacts / static_cast<double>(peer.spheres.size()));
    floor_pressure[0].push_back(-system.wall_wrench(0).force.z() / (width * width));
    floor_pressure[1].push_back(peer.floor_force / (width * width));
  }
  std::filesystem::remove_all(folder);
  expect_same("height_m", height[0], height[1], 0.0);
  expect_same("coordination", coordination_number[0], coordination_number[1], 0.0);
  // At rest both floors carry the weight: 0.5 % for what still trembles.
  expect_same("floor_pressure_pa", floor_pressure[0], floor_pressure[1], 0.005);
}

}  // namespace
}  // namespace wheel_twin::dem
