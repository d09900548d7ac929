// The rim alone against thin-ring theory. Both of the paper's wheels, with the consistent stiffness E I / L.
#include <gtest/gtest.h>

#include <cmath>

#include "cases.h"

namespace wheel_twin::wheel {
namespace {

class Ring : public ::testing::TestWithParam<const char*> {
 protected:
  WheelModel ring(int segments = 64, Bending bending = Bending::beam) const {
    return free_ring(configured_wheel(GetParam(), bending, segments));
  }
  double rigidity() const { return ring().rim.flexural_rigidity(); }
  double radius() const { return ring().radius; }
};

INSTANTIATE_TEST_SUITE_P(PapersWheels, Ring, ::testing::Values("amalia", "t0_r0"));

// The elastica is the closed form at small load: a check of the reference itself.
TEST_P(Ring, ElasticaMeetsTheClosedFormAtSmallLoad) {
  const double W = small_load(radius(), rigidity());
  const DiameterChange exact = ring_under_opposite_loads(radius(), rigidity(), W);
  const DiameterChange shot = elastica(radius(), rigidity(), W);
  EXPECT_NEAR(shot.loaded / exact.loaded, 1.0, 3e-4);
  EXPECT_NEAR(shot.free / exact.free, 1.0, 3e-4);
}

TEST_P(Ring, SmallLoadWithinOnePercent) {
  const double W = 10.0 * small_load(radius(), rigidity());
  const DiameterChange exact = ring_under_opposite_loads(radius(), rigidity(), W);
  const DiameterChange twin = squeeze(ring(), W);
  EXPECT_NEAR(twin.loaded / exact.loaded, 1.0, 0.01);
  EXPECT_NEAR(twin.free / exact.free, 1.0, 0.01);
}

TEST_P(Ring, ElasticaToFifteenPercentOfTheDiameter) {
  for (const double fraction : {0.05, 0.10, 0.15}) {
    const double W = elastica_load(radius(), rigidity(), fraction);
    const DiameterChange exact = elastica(radius(), rigidity(), W);
    const DiameterChange twin = squeeze(ring(), W);
    EXPECT_NEAR(twin.loaded / exact.loaded, 1.0, 0.02) << "at " << fraction;
    EXPECT_NEAR(twin.free / exact.free, 1.0, 0.02) << "at " << fraction;
  }
}

// Straight segments and concentrated bending: second order in the segment's length.
TEST_P(Ring, ConvergesWithTheSecondOrder) {
  const double W = elastica_load(radius(), rigidity(), 0.05);
  const double exact = elastica(radius(), rigidity(), W).loaded;
  double before = 0.0;
  for (const int segments : {32, 64, 128, 256}) {
    const double error = std::abs(squeeze(ring(segments), W).loaded / exact - 1.0);
    if (segments > 32) {
      EXPECT_NEAR(std::log2(before / error), 2.0, 0.1) << segments << " segments";
    }
    before = error;
  }
}

// The printed procedure's joints are 1.167 times as stiff as a bending segment, the ring's deflection that
// much less.
TEST_P(Ring, PrintedStiffnessStiffensTheRing) {
  const double W = 10.0 * small_load(radius(), rigidity());
  const double ratio = squeeze(ring(64, Bending::printed), W).loaded / squeeze(ring(), W).loaded;
  EXPECT_NEAR(ratio, ring().rim_joint_stiffness / ring(64, Bending::printed).rim_joint_stiffness, 2e-3);
  EXPECT_NEAR(ratio, 1.0 / 1.167, 0.002);
}

TEST_P(Ring, NaturalFrequenciesWithinTwoPercent) {
  const WheelModel model = ring();
  const double mass = model.rim.density * model.rim.width * model.rim.thickness;
  for (const int n : {2, 3, 4}) {
    EXPECT_NEAR(measured_frequency(model, n) / ring_frequency(n, radius(), rigidity(), mass), 1.0, 0.02)
        << "mode " << n;
  }
}

}  // namespace
}  // namespace wheel_twin::wheel
