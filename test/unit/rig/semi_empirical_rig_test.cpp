// The rig on the semi-empirical soil: what it settles to is what the static solver of src/terramechanics
// says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rig/free_run.h"
#include "rig/replay.h"
#include "rig/semi_empirical_contact.h"
#include "terramechanics/wheel_on_soil.h"

namespace wheel_twin::rig {
namespace {

terramechanics::Wheel amalia() {
  terramechanics::Wheel wheel;
  wheel.grousers = 24;
  wheel.grouser_height = 0.007;
  wheel.stiffness = 9000.0;
  return wheel;
}

RunSettings settings_of(double slip, double load) {
  RunSettings settings;
  settings.conditions.slip = slip;
  settings.conditions.load = load;
  settings.rig.carriage.belt_stiffness = 2e5;
  settings.profile.travel = 0.25;
  return settings;
}

/// The last step of the steady part. The print of the resting wheel has then been left by ten half contact
/// lengths (0.05 m each at most), and what it still does, exp(-12), is below the tolerances here.
RigStep steady_end(RunSettings settings) {
  SemiEmpiricalContact contact(amalia(), {});
  settings.profile.travel = 0.6;
  settings.step = 0.004;
  FreeRun run(settings, contact, {});
  RigStep last;
  while (!run.timeline() || run.time() < run.timeline()->ramp_down - settings.step) last = run.advance();
  return last;
}

TEST(RigOnSoil, StaticEquilibriumIsTheStaticSinkage) {
  const terramechanics::WheelOnSoil model(amalia(), {});
  for (const double load : {20.0, 42.1, 61.7, 100.0}) {
    SemiEmpiricalContact contact(amalia(), {});
    Rig rig(RigSettings(), settings_of(0.0, load).conditions, 0.09, contact, {});
    const double found = rig.start(std::nullopt).state.hub_displacement;
    // Both balance the load to 1e-6; the displacement follows with an exponent below 1.
    EXPECT_NEAR(found, model.at_rest_under_load(load).hub_displacement, 1e-6 * found) << load;
  }
}

TEST(RigOnSoil, LoweredOnTheSoilItEndsInTheStaticSinkage) {
  SemiEmpiricalContact contact(amalia(), {});
  FreeRun run(settings_of(0.3, 42.1), contact, {});
  double highest = 0.0, displacement = 0.0;
  while (!run.timeline() || run.time() < run.timeline()->ramp_up - 1e-3) {
    highest = std::max(highest, run.advance().load.force_hub_rig.z());
    displacement = run.step().state.hub_displacement;
  }
  const terramechanics::WheelOnSoil model(amalia(), {});
  const double expected = model.at_rest_under_load(42.1).hub_displacement;
  EXPECT_NEAR(displacement, expected, 1e-4 * expected);
  EXPECT_LT(highest, 1.1 * 42.1);  // gently: no impact
}

TEST(RigOnSoil, SteadyForcesAreTheStaticSolvers) {
  const terramechanics::WheelOnSoil model(amalia(), {});
  for (const double load : {42.1, 61.7})
    for (const double slip : {-0.3, 0.0, 0.2, 0.4, 0.6}) {
      const RigStep found = steady_end(settings_of(slip, load));
      const terramechanics::ContactState expected = model.at_load(load, {slip, 0.0});
      EXPECT_NEAR(found.load.force_hub_rig.z(), load, 1e-4 * load) << slip;
      EXPECT_NEAR(found.load.force_hub_rig.x(), expected.drawbar_pull, 1e-4 * load) << slip;
      EXPECT_NEAR(found.load.drive_torque, expected.drive_torque, 1e-4 * load * 0.09) << slip;
      EXPECT_NEAR(found.state.hub_displacement, expected.hub_displacement, 1e-4 * expected.hub_displacement)
          << slip;
    }
}

TEST(RigOnSoil, ATowedWheelFindsTheTowedSlip) {
  const terramechanics::WheelOnSoil model(amalia(), {});
  SemiEmpiricalContact contact(amalia(), {});
  RunSettings settings = settings_of(0.0, 42.1);
  settings.conditions.towed = true;
  FreeRun run(settings, contact, {});
  RunSummary summary;
  run_to_end(run, summary);
  EXPECT_NEAR(summary.slip, model.towed_slip(42.1), 1e-4);
  EXPECT_NEAR(summary.drive_torque, 0.0, 1e-5);
  EXPECT_LT(summary.drawbar_pull, 0.0);
}

TEST(RigOnSoil, SteeringPushesToTheSideItIsTurnedTo) {
  for (const double angle : {0.2, -0.2}) {
    RunSettings settings = settings_of(0.3, 42.1);
    settings.conditions.steering_angle = angle;
    const Eigen::Vector3d force = steady_end(settings).load.force_hub_rig;
    const terramechanics::ContactState expected =
        terramechanics::WheelOnSoil(amalia(), {}).at_load(42.1, {0.3, angle});
    EXPECT_GT(force.y() * angle, 0.0);
    EXPECT_NEAR(force.y(), expected.side_force, 1e-4 * 42.1);
    EXPECT_NEAR(force.x(), expected.drawbar_pull, 1e-4 * 42.1);
  }
}

TEST(RigOnSoil, HalvingTheStepChangesNothingThatASensorSees) {
  double pull[2], depth[2];
  for (const int i : {0, 1}) {
    SemiEmpiricalContact contact(amalia(), {});
    RunSettings settings = settings_of(0.3, 42.1);
    settings.profile.travel = 0.05;
    settings.step = i == 0 ? 0.001 : 0.0005;
    FreeRun run(settings, contact, {});
    RunSummary summary;
    run_to_end(run, summary);
    pull[i] = summary.drawbar_pull;
    depth[i] = summary.hub_displacement;
  }
  EXPECT_NEAR(pull[0], pull[1], 0.005);   // a tenth of the sensor's resolution of 1/16 N
  EXPECT_NEAR(depth[0], depth[1], 5e-6);  // a tenth of the encoder's
}

TEST(RigOnSoil, QuasiStaticReplayFollowsTheSteadySolution) {
  const terramechanics::WheelOnSoil model(amalia(), {});
  SemiEmpiricalContact contact(amalia(), {});
  const Speeds speeds = speeds_of_slip(0.4, 0.2859, 0.09);
  MotionSeries motion;
  for (int i = 0; i <= 600; ++i) {
    MeasuredMotion at;
    at.time = 0.05 * i;
    at.load = 42.1;
    at.carriage_position = speeds.carriage * at.time;
    at.carriage_velocity = speeds.carriage;
    at.wheel_angle = speeds.wheel * at.time;
    at.wheel_rate = speeds.wheel;
    motion.push_back(at);
  }
  SampleTimes times;
  times.wrench = times.displacement = times.effort = {29.0};
  const Prediction found = predict({}, {}, 0.09, contact, {}, motion, times, {});
  const terramechanics::ContactState expected = model.at_load(42.1, {0.4, 0.0});
  EXPECT_NEAR(found.wrench[0].force.x(), expected.drawbar_pull, 1e-3);
  EXPECT_NEAR(found.displacement[0], expected.hub_displacement, 1e-7);
  EXPECT_NEAR(found.effort[0], expected.drive_torque, 1e-4);
}

}  // namespace
}  // namespace wheel_twin::rig
