#include "dem/measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "base/error.h"
#include "dem/vtk.h"

namespace wheel_twin::dem {
namespace {

constexpr double pi = 3.14159265358979323846;

// Simple cubic lattice of spheres of diameter 6 mm, pressed together by `overlap`.
System lattice(double overlap) {
  WorldSettings world;
  const double pitch = 0.006 - overlap;
  world.high = {10 * pitch, 10 * pitch, 0.1};
  world.periodic_x = world.periodic_y = true;
  world.gravity = Eigen::Vector3d::Zero();
  MaterialTable materials;
  materials.add({"grain", 2700.0, 3e7, 0.25});
  System system(world, materials, {make_clump("ball", {{{0, 0, 0}, 0.003}})});
  std::vector<Particle> balls;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j)
      for (int k = 0; k < 10; ++k) {
        Particle ball;
        ball.position = {(i + 0.5) * pitch, (j + 0.5) * pitch, (k + 0.5) * pitch};
        balls.push_back(ball);
      }
  system.add(balls);
  return system;
}

TEST(Measures, DensityOfACubicLattice) {
  const System system = lattice(0.0);
  const Box region{{0, 0, 0}, {0.06, 0.06, 0.06}};
  EXPECT_NEAR(packing_density(system, region), pi / 6.0, 1e-12);
  // Layers of whole lattice planes all have the mean; half of the region has half of the spheres.
  for (const double d : layer_densities(system, region, 0.006)) EXPECT_NEAR(d, pi / 6.0, 1e-12);
  EXPECT_NEAR(packing_density(system, {{0, 0, 0}, {0.06, 0.06, 0.12}}), pi / 12.0, 1e-12);
}

TEST(Measures, CoordinationOfACubicLattice) {
  System system = lattice(1e-5);
  system.step();  // contacts are those of the last step's lists
  const double pitch = 0.006 - 1e-5;
  const Coordination inner = coordination(system, {{0, 0, 2 * pitch}, {0.06, 0.06, 8 * pitch}});
  EXPECT_DOUBLE_EQ(inner.per_clump, 6.0);
  EXPECT_DOUBLE_EQ(inner.per_sphere, 6.0);
}

TEST(Measures, HeightMapOfOneSphere) {
  const HeightMap map = height_map({{{0.01, 0.01, 0.02}, 0.005, 0}}, {{0, 0, 0}, {0.02, 0.02, 0}}, 0.0005);
  double volume = 0.0;
  for (const double h : map.height)
    if (std::isfinite(h)) volume += (h - 0.02) * 0.0005 * 0.0005;
  EXPECT_NEAR(volume, 2.0 / 3.0 * pi * std::pow(0.005, 3), 0.01 * volume);  // the upper half of the sphere
  EXPECT_TRUE(std::isnan(map.at(0, 0)));
}

TEST(Vtk, BlocksLieWhereTheHeaderSays) {
  VtkPolyData data;
  data.points = {0, 0, 0, 1, 2, 3};
  data.fields = {{"radius", 1, {0.5F, 0.25F}}};
  const std::string path = testing::TempDir() + "points.vtp";
  write_vtp(path, data);
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  const std::string bytes = text.str();
  const std::size_t start = bytes.find("encoding=\"raw\">\n_") + 17;
  const auto block = [&](const std::string& name) {
    const std::size_t place = bytes.find("Name=\"" + name + "\"");
    const std::size_t offset = bytes.find("offset=\"", place) + 8;
    return start + std::stoul(bytes.substr(offset));
  };
  std::uint64_t size = 0;
  std::copy_n(bytes.data() + block("Points"), 8, reinterpret_cast<char*>(&size));
  EXPECT_EQ(size, 24U);
  float last = 0.0F;
  std::copy_n(bytes.data() + block("Points") + 8 + 20, 4, reinterpret_cast<char*>(&last));
  EXPECT_EQ(last, 3.0F);
  std::copy_n(bytes.data() + block("radius") + 8 + 4, 4, reinterpret_cast<char*>(&last));
  EXPECT_EQ(last, 0.25F);
  std::remove(path.c_str());
  data.fields[0].values.pop_back();
  EXPECT_THROW(write_vtp(path, data), Error);
}

}  // namespace
}  // namespace wheel_twin::dem
