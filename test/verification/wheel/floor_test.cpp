// The whole wheels on a hard floor, standing and rolling, against CalculiX (calculix/wheel_decks.py; large
// deflection, wide sheets bend as plates) and against what rolling must do. 8.9 % and 6.21 %: the paper's
// largest differences between its multibody and its finite-element model, Sections 6.2 and 8.
#include <gtest/gtest.h>

#include <cmath>

#include "cases.h"

namespace wheel_twin::wheel {
namespace {

double standing_deflection(const WheelModel& model, double load) {
  return load_deflection(model, {load}).front().deflection;
}

TEST(Standing, AmaliaWithinThePapersErrorOfFiniteElements) {
  for (const Bending bending : {Bending::printed, Bending::beam, Bending::plate}) {
    const WheelModel model = configured_wheel("amalia", bending);
    for (const double load : {20.0, 42.1, 61.7}) {
      const double twin = standing_deflection(model, load);
      EXPECT_NEAR(twin / finite_element_drop("amalia", load), 1.0, 0.089)
          << load << " N, bending " << static_cast<int>(bending);
    }
  }
}

TEST(Standing, T0R0WithinThePapersErrorOfFiniteElements) {
  const double fe = finite_element_drop("t0_r0", 81.75);
  EXPECT_NEAR(standing_deflection(configured_wheel("t0_r0", Bending::printed), 81.75) / fe, 1.0, 0.089);
}

class RollingAmalia : public ::testing::Test {
 protected:
  static constexpr double kLoad = 42.1, kSpeed = 0.1, kSettle = 0.05, kPitch = 2.0 * M_PI * 0.0895 / 16.0;
  static Rolling run(double damping, int segments) {
    WheelModel model = configured_wheel("amalia", Bending::plate, segments);
    model.damping_ratio = damping;
    return roll(model, kLoad, kSpeed, kSettle, 2.5 * kPitch, 5.0);
  }
};

TEST_F(RollingAmalia, SteadyHubHeightIsTheFiniteElementOne) {
  const Rolling rolling = run(0.02, 64);
  const RollingMeans mean = means(rolling);
  // Where a spring passes the floor, which is how the finite-element wheel stands.
  const double pitch = M_PI / 8.0;
  const double height = height_at(rolling, pitch * std::ceil(rolling.samples.front().angle / pitch), 0.04);
  EXPECT_NEAR((0.0902 - height) / finite_element_drop("amalia", kLoad), 1.0, 0.0621);
  EXPECT_LT(std::abs(mean.thrust), 1e-3 * kLoad) << "free rolling pulls";
  EXPECT_LT(mean.radius, 0.0902);
  EXPECT_GT(mean.radius, mean.hub_height);
}

TEST_F(RollingAmalia, ResistanceFallsToZeroWithDamping) {
  const double strong = means(run(0.04, 64)).resistance;
  const double weak = means(run(0.01, 64)).resistance;
  EXPECT_GT(strong, 2.0 * weak);
  EXPECT_LT(weak, 1e-4 * kLoad);
}

TEST(RollingAmaliaSlowly, RippleOfTheSegmentsVanishesWithTheirCount) {
  double before = ripple(roll_without_bounce(32), 32.0);
  for (const int segments : {48, 64}) {
    const double now = ripple(roll_without_bounce(segments), segments);
    EXPECT_LT(now, 0.5 * before) << segments << " segments";
    before = now;
  }
}

// A strip of half the stiffness: the hub dips once a turn, by what the finite-element wheel drops more on it.
TEST(SoftStrip, DipsOnceATurnByTheRightAmount) {
  WheelModel model = configured_wheel("amalia", Bending::plate);
  model.faults = {{8, 0, 0.5}, {8, 1, 0.5}};  // at the bottom of the unturned wheel
  const double fe = finite_element_drop("amalia_soft_strip", 20.0) - finite_element_drop("amalia", 20.0);
  WheelModel sound = model;
  sound.faults.clear();
  EXPECT_NEAR((standing_deflection(model, 20.0) - standing_deflection(sound, 20.0)) / fe, 1.0, 0.089);
  const double standing = standing_deflection(model, 42.1) - standing_deflection(sound, 42.1);
  const Rolling rolling = roll(model, 42.1, 0.3, 0.05, 2.0 * M_PI * 0.092, 20.0);
  const double pitch = M_PI / 8.0;
  double others = 0.0;
  for (int k = 3; k <= 13; ++k) others += height_at(rolling, k * pitch, 0.03) / 11.0;
  const double dip = others - height_at(rolling, 0.0, 0.03);
  EXPECT_NEAR(dip / standing, 1.0, 0.25) << "rolling over it at 0.3 m/s, vibration included";
}

}  // namespace
}  // namespace wheel_twin::wheel
