#include "rig/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "rig/free_run.h"
#include "test_contact.h"

namespace wheel_twin::rig {
namespace {

constexpr double radius = 0.09;

/// 2 s at rest, then at the speeds of `slip`, sampled at `rate`.
MotionSeries motion_of(double slip, double seconds, double rate = 50.0, double load = 42.1) {
  const Speeds speeds = speeds_of_slip(slip, 0.2859, radius);
  MotionSeries series;
  for (int i = 0; i <= static_cast<int>(seconds * rate); ++i) {
    MeasuredMotion motion;
    motion.time = i / rate;
    const double moving = std::max(0.0, motion.time - 2.0);
    motion.carriage_position = speeds.carriage * moving;
    motion.carriage_velocity = moving > 0.0 ? speeds.carriage : 0.0;
    motion.wheel_angle = 5.8 + speeds.wheel * moving;
    motion.wheel_rate = moving > 0.0 ? speeds.wheel : 0.0;
    motion.load = load;
    series.push_back(motion);
  }
  return series;
}

RunConditions conditions() {
  RunConditions set;
  set.load = 42.1;
  return set;
}

TEST(Replay, GivesEveryChannelAtTheAskedStamps) {
  TestContact contact;
  SampleTimes times;
  times.wrench = {0.5, 1.0, 7.77, 100.0};
  times.displacement = {9.0};
  times.effort = {1.0, 9.0};
  const Prediction found =
      predict(plain_rig(), conditions(), radius, contact, {}, motion_of(0.4, 10.0), times, {});
  ASSERT_EQ(found.wrench.size(), 4u);
  EXPECT_EQ(found.wrench[0].force.x(), 0.0);  // at rest
  EXPECT_NEAR(found.wrench[0].force.z(), 42.1, 1e-4);
  for (const std::size_t i : {2u, 3u}) EXPECT_NEAR(found.wrench[i].force.x(), 0.5 * 0.4 * 42.1 - 1.0, 1e-4);
  EXPECT_NEAR(found.displacement[0], 42.1 / contact.stiffness, 1e-8);
  EXPECT_EQ(found.effort[0], 0.0);
  EXPECT_NEAR(found.effort[1], radius * 0.2 * 42.1, 1e-4);
}

TEST(Replay, QuasiStaticAndDynamicAgreeOnceSettled) {
  TestContact contact;
  RigSettings settings = plain_rig();
  settings.slide.viscous_damping = 60.0;
  SampleTimes times;
  times.wrench = times.displacement = times.effort = {9.5};
  ReplayOptions dynamic;
  dynamic.slide = Slide::dynamic;
  dynamic.step = 0.001;
  const MotionSeries motion = motion_of(0.3, 10.0);
  const Prediction slow = predict(settings, conditions(), radius, contact, {}, motion, times, dynamic);
  const Prediction fast = predict(settings, conditions(), radius, contact, {}, motion, times, {});
  EXPECT_NEAR(slow.wrench[0].force.x(), fast.wrench[0].force.x(), 1e-4);
  EXPECT_NEAR(slow.displacement[0], fast.displacement[0], 1e-8);
  EXPECT_NEAR(slow.effort[0], fast.effort[0], 1e-5);
}

TEST(Replay, SampleBySampleIsTheSameAsAtOnce) {
  TestContact contact;
  const MotionSeries motion = motion_of(0.3, 5.0);
  SampleTimes times;
  for (const MeasuredMotion& at : motion) times.wrench.push_back(at.time);
  const Prediction at_once = predict(plain_rig(), conditions(), radius, contact, {}, motion, times, {});
  Replay replay(plain_rig(), conditions(), radius, contact, {}, {});
  for (std::size_t i = 0; i < motion.size(); ++i)
    EXPECT_NEAR(replay.update(motion[i]).readings.wrench.force.x(), at_once.wrench[i].force.x(), 1e-6) << i;
}

TEST(Replay, GoesOnAfterAJumpOfTheClock) {
  TestContact contact;
  Replay replay(plain_rig(), conditions(), radius, contact, {}, {});
  MotionSeries motion = motion_of(0.3, 4.0);
  for (std::size_t i = 0; i < 150; ++i) replay.update(motion[i]);
  const double travel = replay.step().state.rim_travel;
  EXPECT_THROW(replay.update(motion[100]), Error);
  replay.rebase(motion[149].time - 1000.0);
  for (std::size_t i = 150; i < motion.size(); ++i) {
    motion[i].time -= 1000.0;
    replay.update(motion[i]);
  }
  EXPECT_NEAR(replay.step().readings.wrench.force.x(), 0.5 * 0.3 * 42.1 - 1.0, 1e-4);
  EXPECT_GT(replay.step().state.rim_travel, travel);
  EXPECT_NEAR(replay.step().state.rim_travel,
              radius * (motion.back().wheel_angle - motion.front().wheel_angle), 1e-9);
}

TEST(Replay, TakesEncoderNoiseAtRestForRest) {
  TestContact contact;
  Replay replay(plain_rig(), conditions(), radius, contact, {}, {});
  MeasuredMotion motion;
  motion.load = 42.1;
  for (int i = 0; i < 20; ++i) {
    motion.time = 0.02 * i;
    motion.carriage_velocity = i % 2 == 0 ? 1e-4 : -1e-4;
    motion.wheel_rate = i % 3 == 0 ? 1e-3 : -5e-4;
    EXPECT_EQ(replay.update(motion).readings.wrench.force.x(), 0.0);
  }
}

TEST(Replay, HonoursTheDelayOfTheDrawWire) {
  struct Late : SensorPort {
    void change_displacement(const RigState& state, double, double& displacement) const override {
      displacement = state.time;  // a reading that tells when it was taken
    }
    double draw_wire_delay() const override { return 0.3; }
  } late;
  TestContact contact;
  Ports ports;
  ports.sensor.push_back(&late);
  SampleTimes times;
  times.displacement = {1.0, 1.234, 9.0};
  const Prediction found =
      predict(plain_rig(), conditions(), radius, contact, ports, motion_of(0.2, 10.0), times, {});
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found.displacement[i], times.displacement[i] - 0.3, 1e-9);
}

TEST(Replay, FollowsTheLoadAndTheSlideSticks) {
  struct Friction : RigPort {
    double coulomb_friction(const RigState&) const override { return 2.0; }
  } friction;
  TestContact contact;
  Ports ports;
  ports.rig.push_back(&friction);
  Replay replay(plain_rig(), conditions(), radius, contact, ports, {});
  MeasuredMotion motion;
  motion.load = 40.0;
  const double deep = replay.update(motion).state.hub_displacement;
  EXPECT_NEAR(deep, 40.0 / contact.stiffness, 1e-8);
  const auto at_load = [&](double load) {
    motion.time += 1.0;
    motion.load = load;
    return replay.update(motion).state.hub_displacement;
  };
  EXPECT_EQ(at_load(41.9), deep);                              // within the friction: stands
  EXPECT_NEAR(at_load(45.0), 43.0 / contact.stiffness, 1e-8);  // sinks until friction holds
  EXPECT_NEAR(at_load(42.0), 43.0 / contact.stiffness, 1e-8);  // and stands
  EXPECT_NEAR(at_load(38.0), 40.0 / contact.stiffness, 1e-8);  // rises until friction holds
}

TEST(Replay, ReproducesAFreeRunFromItsLog) {
  TestContact contact;
  RunSettings settings;
  settings.rig = plain_rig();
  settings.rig.slide.viscous_damping = 200.0;
  settings.conditions.slip = 0.35;
  settings.conditions.wheel_angle = 1.0;
  settings.profile.travel = 0.05;
  FreeRun run(settings, contact, {});
  RunSummary summary;
  const run_log::RunLog log = run_to_end(run, summary);
  const MotionSeries motion = motion_of_log(log, settings.conditions, 0.05);
  SampleTimes times;
  times.wrench = {summary.window[0] + 0.5};
  times.displacement = times.effort = times.wrench;
  const Prediction found = predict(settings.rig, settings.conditions, radius, contact, {}, motion, times, {});
  EXPECT_NEAR(found.wrench[0].force.x(), summary.drawbar_pull, 1e-3);
  EXPECT_NEAR(found.wrench[0].force.z(), summary.normal_load, 1e-3);
  EXPECT_NEAR(found.displacement[0], summary.hub_displacement, 1e-6);
  EXPECT_NEAR(found.effort[0], summary.motor_effort, 1e-4);
}

TEST(Replay, SmoothingKeepsMeansAndRamps) {
  run_log::RunLog log;
  for (int i = 0; i < 100; ++i) {
    const double t = 0.02 * i;
    log.joints.time.push_back(t);
    log.joints.carriage_position.push_back(0.5 * t * t);
    log.joints.carriage_velocity.push_back(t + (i % 2 == 0 ? 0.01 : -0.01));
    log.joints.wheel_angle.push_back(0.0);
    log.joints.wheel_rate.push_back(1.0);
    log.joints.wheel_effort.push_back(0.0);
  }
  const MotionSeries motion = motion_of_log(log, conditions(), 0.2);
  ASSERT_EQ(motion.size(), 100u);
  EXPECT_NEAR(motion[50].carriage_velocity, 1.0, 0.01 / 11.0 + 1e-12);  // eleven samples, one noise left over
  EXPECT_NEAR(motion[50].wheel_rate, 1.0, 1e-12);
  EXPECT_EQ(motion[50].load, 42.1);
  EXPECT_EQ(motion[50].temperature, 22.0);
  EXPECT_THROW(motion_of_log({}, conditions()), Error);
}

TEST(Replay, RefusesWhatItCannotDo) {
  TestContact contact;
  contact.again = false;
  try {
    predict(plain_rig(), conditions(), radius, contact, {}, motion_of(0.1, 1.0), {}, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("evaluated again"));
  }
  contact.again = true;
  EXPECT_THROW(predict(plain_rig(), conditions(), radius, contact, {}, {}, {}, {}), Error);
  ReplayOptions options;
  options.step = 0.0;
  EXPECT_THROW(predict(plain_rig(), conditions(), radius, contact, {}, motion_of(0.1, 1.0), {}, options),
               Error);
}

}  // namespace
}  // namespace wheel_twin::rig
