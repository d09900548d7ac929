#include "rig/free_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../message_of.h"
#include "test_contact.h"

namespace wheel_twin::rig {
namespace {

RunSettings settings_of(double slip) {
  RunSettings settings;
  settings.rig = plain_rig();
  settings.rig.slide.viscous_damping = 60.0;
  settings.conditions.slip = slip;
  settings.profile.travel = 0.02;
  settings.profile.dwell = 0.3;
  settings.profile.rest = 0.3;
  return settings;
}

TEST(Profile, RampsAndHolds) {
  RunProfile profile;
  profile.dwell = 2.0;
  profile.ramp = 0.1;
  profile.travel = 0.7;
  profile.rest = 1.0;
  const Timeline line = timeline(profile, speeds_of_slip(0.0, 0.2859, 0.09), 1.0);
  EXPECT_DOUBLE_EQ(line.ramp_up, 3.0);
  EXPECT_NEAR(line.ramp_down - line.steady, 0.7 / (0.09 * 0.2859), 1e-9);
  EXPECT_EQ(speed_share(line, 2.9), 0.0);
  EXPECT_NEAR(speed_share(line, 3.05), 0.5, 1e-9);
  EXPECT_EQ(speed_share(line, 10.0), 1.0);
  EXPECT_NEAR(speed_share(line, line.ramp_down + 0.075), 0.25, 1e-9);
  EXPECT_EQ(speed_share(line, line.end), 0.0);
  const Timeline spinning = timeline(profile, speeds_of_slip(1.0, 0.2859, 0.09), 1.0);
  EXPECT_DOUBLE_EQ(spinning.ramp_down - spinning.steady, profile.longest_steady);
}

TEST(FreeRun, GoesThroughItsPhases) {
  TestContact contact;
  FreeRun run(settings_of(0.3), contact, {});
  double before_touch = 0.0, highest_force = 0.0, deepest = 0.0;
  while (!run.timeline()) {
    const RigStep& step = run.advance();
    if (step.load.force_hub_rig.z() <= 0.0) before_touch = step.state.slide_velocity;
    highest_force = std::max(highest_force, step.load.force_hub_rig.z());
    EXPECT_EQ(step.state.carriage_speed, 0.0);
    ASSERT_LT(run.time(), 10.0);
  }
  EXPECT_NEAR(before_touch, -0.01, 1e-12);  // lowered at the hoist's speed
  EXPECT_LT(highest_force,
            1.02 * 42.1 + 0.6);  // gently: the slide's momentum at 10 mm/s, sqrt(k m) v = 1.3 N, damped
  const Timeline line = *run.timeline();
  double steady_drawbar_pull = 0.0;
  while (!run.done()) {
    const RigStep& step = run.advance();
    deepest = std::max(deepest, step.state.hub_displacement);
    if (step.state.time < line.ramp_up) {
      EXPECT_EQ(step.state.carriage_speed, 0.0);
    }
    if (step.state.time > line.steady && step.state.time <= line.ramp_down)
      steady_drawbar_pull = step.load.force_hub_rig.x();
  }
  EXPECT_NEAR(steady_drawbar_pull, 0.5 * 0.3 * 42.1 - 1.0, 1e-3);
  EXPECT_EQ(run.step().state.carriage_speed, 0.0);
  EXPECT_NEAR(run.step().state.x, 0.02 + 0.1 * 0.7 * 0.09 * 0.285885, 1e-5);  // travel, and half of each ramp
  EXPECT_NEAR(run.time(), line.end, 1e-3);
  EXPECT_NEAR(run.step().state.hub_displacement, 42.1 / contact.stiffness, 1e-5);
}

TEST(FreeRun, SummaryIsTheStaticSolution) {
  TestContact contact;
  FreeRun run(settings_of(0.5), contact, {});
  RunSummary summary;
  int seen = 0;
  const run_log::RunLog log = run_to_end(run, summary, {[&](const RigStep&) { ++seen; }});
  EXPECT_NEAR(summary.drawbar_pull, 0.5 * 0.5 * 42.1 - 1.0, 1e-3);
  EXPECT_NEAR(summary.normal_load, 42.1, 1e-3);
  EXPECT_NEAR(summary.hub_displacement, 42.1 / contact.stiffness, 2e-7);
  EXPECT_NEAR(summary.drive_torque, 0.09 * 0.25 * 42.1, 1e-3);
  EXPECT_NEAR(summary.slip, 0.5, 1e-9);
  EXPECT_EQ(static_cast<std::size_t>(seen), log.ft.time.size());  // both every millisecond
  EXPECT_NEAR(log.ft.force[0].z(), 0.0, 1e-12);                   // starts tared, in the air
}

TEST(FreeRun, SameSeedSameBits) {
  RunSettings settings = settings_of(0.2);
  settings.sensors.ft.noise.setConstant(0.05);
  const auto log = [&] {
    TestContact contact;
    FreeRun run(settings, contact, {});
    RunSummary summary;
    return run_to_end(run, summary);
  };
  const run_log::RunLog a = log();
  const run_log::RunLog b = log();
  EXPECT_EQ(a.ft.force, b.ft.force);
  EXPECT_EQ(a.ft.torque, b.ft.torque);
  EXPECT_EQ(a.draw_wire.value, b.draw_wire.value);
  EXPECT_EQ(a.joints.wheel_angle, b.joints.wheel_angle);
  settings.seed = 2;
  EXPECT_NE(a.ft.force, log().ft.force);
}

TEST(FreeRun, TowedAndBrakingWheelsPullBack) {
  TestContact contact;
  RunSettings settings = settings_of(0.0);
  settings.conditions.towed = true;
  RunSummary summary;
  FreeRun towed(settings, contact, {});
  run_to_end(towed, summary);
  EXPECT_NEAR(summary.drawbar_pull, -1.0, 1e-3);
  EXPECT_NEAR(summary.drive_torque, 0.0, 1e-6);
  FreeRun locked(settings_of(-1.0), contact, {});
  run_to_end(locked, summary);
  EXPECT_NEAR(summary.drawbar_pull, -0.5 * 42.1 - 1.0, 1e-3);
  EXPECT_NEAR(summary.slip, -1.0, 1e-12);
}

TEST(FreeRun, StopsWhenAPersonPressesStop) {
  TestContact contact;
  RunSettings settings = settings_of(0.3);
  settings.profile.travel = 0.5;
  FreeRun run(settings, contact, {});
  while (!run.timeline() || run.time() < run.timeline()->steady + 0.5) run.advance();
  const double stopped = run.time();
  run.stop();
  double last = run.step().state.carriage_speed;
  while (!run.done()) {
    EXPECT_LE(run.advance().state.carriage_speed, last + 1e-15);
    last = run.step().state.carriage_speed;
  }
  EXPECT_EQ(last, 0.0);
  EXPECT_NEAR(run.time(), stopped + 0.1 + 0.3, 2e-3);

  FreeRun early(settings, contact, {});
  early.advance();
  early.stop();
  EXPECT_TRUE(early.done());
}

TEST(FreeRun, RefusesImpossibleRuns) {
  TestContact contact;
  RunSettings settings = settings_of(0.3);
  settings.profile.travel = 3.0;
  settings.profile.longest_steady = 1000.0;
  EXPECT_THAT(message_of([&] { FreeRun(settings, contact, {}); }), testing::HasSubstr("travels"));
  settings = settings_of(0.3);
  settings.step = 0.1;
  EXPECT_THAT(message_of([&] { FreeRun(settings, contact, {}); }), testing::HasSubstr("step"));
  settings = settings_of(0.3);
  settings.epoch = 0.0;
  EXPECT_THAT(message_of([&] { FreeRun(settings, contact, {}); }), testing::HasSubstr("epoch"));
  settings = settings_of(0.3);
  settings.rig.slide.coulomb_friction = 100.0;
  EXPECT_THAT(message_of([&] {
                FreeRun run(settings, contact, {});
                while (!run.done()) run.advance();
              }),
              testing::HasSubstr("hangs in the guide"));
}

}  // namespace
}  // namespace wheel_twin::rig
