#include "dem/cloud.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

ClumpFamily dumbbells() {
  ClumpFamily family;
  family.name = "dumbbells";
  family.shapes = {make_clump("short", {{{0, 0, 0}, 0.003}, {{0.002, 0, 0}, 0.003}}),
                   make_clump("long", {{{0, 0, 0}, 0.003}, {{0.005, 0, 0}, 0.003}})};
  family.shares = {0.5, 0.5};
  family.smallest_size = 0.9;
  family.largest_size = 1.1;
  return family;
}

struct Ball {
  Eigen::Vector3d center;
  double radius;
  std::size_t clump;
};

std::vector<Ball> balls_of(const ClumpFamily& family, const std::vector<Particle>& cloud) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (const ClumpSphere& s : family.shapes[cloud[i].shape].spheres)
      balls.push_back({cloud[i].position + cloud[i].orientation * (cloud[i].size * s.center),
                       cloud[i].size * s.radius, i});
  return balls;
}

TEST(Cloud, NothingTouchesAcrossPeriodicSidesEither) {
  const ClumpFamily family = dumbbells();
  CloudRegion region;
  region.high = {0.05, 0.04, 0.06};
  region.periodic_x = true;
  Random random(1);
  const auto count = static_cast<std::size_t>(0.25 * 0.05 * 0.04 * 0.06 / family.mean_volume());
  const std::vector<Ball> balls = balls_of(family, random_cloud(family, region, count, random, 0));
  for (const Ball& a : balls) {
    EXPECT_GE(a.center.y() - a.radius, 0.0);
    EXPECT_LE(a.center.y() + a.radius, 0.04);
    EXPECT_GE(a.center.z() - a.radius, 0.0);
    EXPECT_LE(a.center.z() + a.radius, 0.06);
    for (const Ball& b : balls) {
      if (a.clump == b.clump) continue;
      Eigen::Vector3d d = a.center - b.center;
      d.x() -= 0.05 * std::round(d.x() / 0.05);
      EXPECT_GE(d.norm(), a.radius + b.radius);
    }
  }
}

TEST(Cloud, ShapesInEqualPartsSizesUniformOrientationsIsotropic) {
  const ClumpFamily family = dumbbells();
  CloudRegion region;
  region.high = {0.2, 0.2, 0.2};
  Random random(4);
  const std::size_t count = 4000;
  const std::vector<Particle> cloud = random_cloud(family, region, count, random, 7);
  std::array<int, 2> shapes{};
  double size = 0.0;
  Eigen::Matrix3d axis = Eigen::Matrix3d::Zero();
  for (const Particle& p : cloud) {
    ++shapes[p.shape];
    EXPECT_EQ(p.material, 7U);
    EXPECT_GE(p.size, 0.9F);
    EXPECT_LE(p.size, 1.1F);
    size += p.size / count;
    const Eigen::Vector3d x = p.orientation * Eigen::Vector3d::UnitX();
    axis += x * x.transpose() / count;
  }
  EXPECT_EQ(shapes[0], shapes[1]);
  // Standard errors: size 0.2/sqrt(12)/sqrt(4000) = 0.0009; squared direction cosine sqrt(4/45)/sqrt(4000) =
  // 0.0047.
  EXPECT_NEAR(size, 1.0, 4 * 0.0009);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(axis(k, k), 1.0 / 3.0, 4 * 0.0047);
}

TEST(Cloud, SameSeedSameCloud) {
  const ClumpFamily family = dumbbells();
  CloudRegion region;
  region.high = {0.05, 0.05, 0.05};
  Random a(9), b(9);
  const auto one = random_cloud(family, region, 100, a, 0);
  const auto two = random_cloud(family, region, 100, b, 0);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].position, two[i].position);
    EXPECT_EQ(one[i].orientation.coeffs(), two[i].orientation.coeffs());
  }
}

TEST(Cloud, SaysWhenThereIsNoRoom) {
  const ClumpFamily family = dumbbells();
  CloudRegion region;
  region.high = {0.03, 0.03, 0.03};
  Random random(1);
  EXPECT_THROW(random_cloud(family, region, 1000, random, 0), Error);
}

}  // namespace
}  // namespace wheel_twin::dem
