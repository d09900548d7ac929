#include "dem/reference_bed.h"

#include <gtest/gtest.h>

#include <cmath>

namespace wheel_twin::dem {
namespace {

TEST(ReferenceBed, CopiesSideBySideMoveAsTheOne) {
  ReferenceBed bed;
  bed.clumps = false;
  bed.spheres = 800;
  GranularSoil soil;
  System one = make_reference_world(bed, soil);
  settle_reference_bed(one, bed, soil, [](double) {});
  System six = tiled_reference_bed(one, bed, soil, 2, 3);
  ASSERT_EQ(six.size(), 6 * one.size());
  // A blow, the same everywhere; contacts across the seams carry it on with the springs that they had.
  for (System* system : {&one, &six}) {
    for (std::size_t k = 0; k < system->size(); k += one.size())
      system->set_velocity(k + 7, {0.05, -0.03, 0.02}, {0.0, 0.0, 0.0});
    system->step(300);
  }
  EXPECT_EQ(six.statistics().contacts, 6 * one.statistics().contacts);
  const Eigen::Vector3d period = one.settings().high - one.settings().low;
  double worst = 0.0;
  for (std::size_t k = 0; k < six.size(); ++k) {
    Eigen::Vector3d d = six.particle(k).position - one.particle(k % one.size()).position;
    for (int a = 0; a < 2; ++a) d[a] -= period[a] * std::round(d[a] / period[a]);
    worst = std::max(worst, d.norm());
  }
  EXPECT_LT(worst, 1e-9);
}

}  // namespace
}  // namespace wheel_twin::dem
