// Both wheels rolling on a hard floor against the static heights of the beam model (beam_model.py, itself
// held against CalculiX below): steady height, free rolling, ripple of a wheel with a position missing. 6.21
// and 8.9 %: the paper's largest differences between its multibody and its finite-element model,
// Sections 6.2, 8.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "cases.h"

namespace wheel_twin::wheel {
namespace {

double load_of(const std::string& wheel) {
  return wheel == "amalia" ? 42.1 : 81.75;
}
double pitch_of(const WheelModel& model) {
  return 2.0 * M_PI * model.radius / 16.0;
}
double undeformed(const WheelModel& model) {
  return model.radius + 0.5 * model.rim.thickness;
}

class BothWheels : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(PapersWheels, BothWheels, ::testing::Values("amalia", "t0_r0"));

// Two independent programs, the same wheel: where CalculiX converges they agree.
TEST_P(BothWheels, BeamModelStandsAsCalculixDoes) {
  const double drop = undeformed(plate_wheel(GetParam())) - beam_model_height(GetParam(), false, 0.0);
  EXPECT_NEAR(drop / finite_element_drop(GetParam(), load_of(GetParam())), 1.0, 0.015);
}

// On a spring and between two springs, where CalculiX finds no equilibrium.
TEST_P(BothWheels, StandsAsTheBeamModelDoes) {
  for (const double degrees : {0.0, 11.25}) {
    const WheelModel model = plate_wheel(GetParam());
    const double twin =
        load_deflection(model, {load_of(GetParam())}, degrees * M_PI / 180.0).front().deflection;
    const double reference = undeformed(model) - beam_model_height(GetParam(), false, degrees);
    EXPECT_NEAR(twin / reference, 1.0, 0.0621) << degrees << " deg";
  }
}

TEST_P(BothWheels, RollsAtTheHeightOfTheBeamModel) {
  const WheelModel model = plate_wheel(GetParam());
  const double pitch = pitch_of(model);
  const Rolling rolling = roll(model, load_of(GetParam()), 0.15, 0.5 * pitch, pitch, 20.0);
  const RollingMeans mean = means(rolling);
  const double drop = undeformed(model) - mean.hub_height;
  EXPECT_NEAR(drop / (undeformed(model) - beam_model_mean(GetParam(), false)), 1.0, 0.0621);
  EXPECT_LT(std::abs(mean.thrust), 2e-3 * load_of(GetParam())) << "free rolling pulls";
  EXPECT_LT(mean.radius, undeformed(model));
  EXPECT_GT(mean.radius, mean.hub_height);
}

// Once brought to speed and left alone, an undamped wheel keeps it.
TEST(FreeRolling, KeepsItsSpeed) {
  WheelModel model = plate_wheel("amalia");
  model.damping_ratio = 0.0;
  RollingSettings settings;
  settings.speed = 0.3;
  settings.coasts = true;
  settings.ground.contact = {5.0e5, 0.0, 0.8};
  RollingWheel wheel(model, settings);
  wheel.settle();
  const double pitch = pitch_of(model);
  // Mean speeds over a pitch, early and two pitches later.
  const auto pass = [&](double until) {
    while (wheel.wheel().hub().position.x() < until) wheel.step();
    return wheel.time();
  };
  const double start = settings.speed * settings.ramp;
  const double t0 = pass(start), t1 = pass(start + pitch), t2 = pass(start + 2.0 * pitch),
               t3 = pass(start + 3.0 * pitch);
  EXPECT_NEAR((t1 - t0) / (t3 - t2), 1.0, 0.02);
  EXPECT_NEAR(pitch / (t1 - t0), settings.speed, 0.02 * settings.speed);
}

// A position without springs or beams: the hub dips once a turn; the first harmonic of its height.
TEST_P(BothWheels, MissingPositionRipplesOnceATurn) {
  if (GetParam() == "t0_r0" && !long_run()) GTEST_SKIP() << "minutes: scripts/validate wheel";
  WheelModel model = plate_wheel(GetParam());
  model.faults = {{8, 0, 0.0}, {8, 1, 0.0}};
  const Rolling rolling =
      roll(model, load_of(GetParam()), 0.15, 0.5 * pitch_of(model), 2.04 * M_PI * model.radius, 20.0);
  EXPECT_NEAR(ripple(rolling, 1.0) / beam_model_ripple(GetParam(), 1), 1.0, 0.089);
}

}  // namespace
}  // namespace wheel_twin::wheel
