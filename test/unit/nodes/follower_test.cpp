#include "nodes/follower.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

constexpr Nanoseconds second = 1000000000;
constexpr Nanoseconds epoch = 1703240800LL * second;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Nanoseconds at(double time) {
  return epoch + std::llround(time * 1e9);
}

/// Predicts a drawbar pull of 2 N a metre of carriage position, and counts its starts.
class FakeTwin : public FollowedTwin {
 public:
  struct Seen {
    int resets = 0;
    std::vector<rig::MeasuredMotion> motions;
    bool breaks = false;
  };
  explicit FakeTwin(Seen& seen) : seen_(seen) {}
  rig::RigStep predict(const rig::MeasuredMotion& motion) override {
    if (seen_.breaks) throw Error("soil cannot carry the load");
    seen_.motions.push_back(motion);
    rig::RigStep step;
    step.readings.wrench.force.x() = 2.0 * motion.carriage_position;
    step.readings.displacement = 0.01;
    return step;
  }
  void reset() override { ++seen_.resets; }

 private:
  Seen& seen_;
};

/// A rig whose channels are straight lines in time, so that interpolation has to give them back exactly.
struct FollowerTest : testing::Test {
  FakeTwin::Seen seen;
  FollowerSettings settings;

  Follower make() { return Follower(settings, std::make_unique<FakeTwin>(seen)); }
  static void wrench(Follower& f, double t) { f.wrench(at(t), {{3.0 * t, 0.0, 40.0}, {0.0, t, 0.0}}); }
  static void wire(Follower& f, double t) { f.displacement(at(t), 0.001 * t); }
  static void joints(Follower& f, double t) {
    rig::JointReading reading;
    reading.carriage_position = 0.02 * t;
    reading.carriage_velocity = 0.02;
    reading.wheel_angle = 0.3 * t;
    reading.wheel_rate = 0.3;
    reading.wheel_effort = 1.0 + t;
    f.joints(at(t), reading);
  }
};

std::vector<Tick> operator+(std::vector<Tick> a, const std::vector<Tick>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST_F(FollowerTest, BringsChannelsOfDifferentRatesToCommonTicks) {
  Follower follower = make();
  std::vector<Tick> ticks;
  for (int ms = 0; ms <= 2000; ++ms) {  // 1 kHz wrench, 50 Hz draw wire, 40 Hz joints half a millisecond late
    wrench(follower, 1e-3 * ms);
    if (ms % 20 == 0) wire(follower, 1e-3 * ms);
    if (ms % 25 == 0) joints(follower, 1e-3 * ms + 0.0005);
    ticks = ticks + follower.take();
  }
  // From the first joint sample (0.5 ms) to the last that all channels have reached, at 100 Hz.
  ASSERT_EQ(ticks.size(), 200u);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double t = 0.01 * static_cast<double>(i + 1);
    EXPECT_EQ(ticks[i].stamp, at(t));
    ASSERT_TRUE(ticks[i].wrench && ticks[i].displacement && ticks[i].effort);
    EXPECT_NEAR(ticks[i].wrench->force.x(), 3.0 * t, 1e-9);
    EXPECT_NEAR(ticks[i].wrench->torque.y(), t, 1e-9);
    EXPECT_NEAR(*ticks[i].displacement, 0.001 * t, 1e-12);
    EXPECT_NEAR(*ticks[i].effort, 1.0 + t, 1e-9);
    EXPECT_NEAR(ticks[i].motion.carriage_position, 0.02 * t, 1e-12);
    EXPECT_NEAR(ticks[i].twin.readings.wrench.force.x(), 0.04 * t, 1e-12);
    // No channel is further apart than 25 ms: nothing waits longer.
    EXPECT_LE(ticks[i].delay, 25000000);
  }
}

TEST_F(FollowerTest, AMissingTopicDelaysByTheLongestWaitAndNoMore) {
  settings.longest_wait = 0.1;
  Follower follower = make();
  std::vector<Tick> ticks;
  for (int ms = 0; ms <= 3000; ms += 10) {
    joints(follower, 1e-3 * ms);
    wire(follower, 1e-3 * ms);
    ticks = ticks + follower.take();
  }
  ASSERT_EQ(ticks.size(), 291u);  // all but the last 0.1 s
  for (const Tick& tick : ticks) {
    EXPECT_FALSE(tick.wrench);
    EXPECT_TRUE(tick.displacement);
    EXPECT_EQ(tick.delay, 100000000);
    EXPECT_EQ(tick.motion.load, settings.declared_load);
  }
  EXPECT_EQ(follower.events().incomplete, ticks.size());
}

TEST_F(FollowerTest, WithoutJointsThereIsNoPrediction) {
  Follower follower = make();
  for (int ms = 0; ms <= 3000; ++ms) {
    wrench(follower, 1e-3 * ms);
    wire(follower, 1e-3 * ms);
    EXPECT_TRUE(follower.take().empty());
  }
}

TEST_F(FollowerTest, ABagThatLoopsStartsTheTwinAgain) {
  Follower follower = make();
  std::vector<Tick> ticks;
  const int resets = seen.resets;
  for (int round = 0; round < 3; ++round)
    for (int ms = 0; ms <= 1000; ms += 10) {
      wrench(follower, 1e-3 * ms);
      wire(follower, 1e-3 * ms);
      joints(follower, 1e-3 * ms);
      ticks = ticks + follower.take();
    }
  EXPECT_EQ(follower.events().jumps, 2u);
  EXPECT_EQ(seen.resets - resets, 2);
  EXPECT_EQ(ticks.size(), 3u * 101u);
  EXPECT_EQ(ticks[101].stamp, at(0.0));
  EXPECT_EQ(ticks[101].motion.time, 0.0);  // the twin's clock starts again
}

TEST_F(FollowerTest, AClockThatJumpsForwardStartsTheTwinAgainAfterTheGap) {
  Follower follower = make();
  std::vector<Tick> ticks;
  for (double start : {0.0, 3600.0})
    for (int ms = 0; ms <= 1000; ms += 10) {
      wrench(follower, start + 1e-3 * ms);
      wire(follower, start + 1e-3 * ms);
      joints(follower, start + 1e-3 * ms);
      ticks = ticks + follower.take();
    }
  EXPECT_EQ(follower.events().gaps, 1u);
  EXPECT_EQ(ticks.size(), 2u * 101u);  // and none in the hour between
  EXPECT_EQ(ticks[101].stamp, at(3600.0));
  EXPECT_EQ(ticks[101].motion.time, 0.0);
}

TEST_F(FollowerTest, SamplesThatAreNotFiniteRepeatedOrWithoutAStampAreLeftOutAndCounted) {
  Follower follower = make();
  std::vector<Tick> ticks;
  for (int ms = 0; ms <= 1000; ms += 10) {
    wrench(follower, 1e-3 * ms);
    wire(follower, 1e-3 * ms);
    joints(follower, 1e-3 * ms);
    if (ms == 500) {
      follower.wrench(at(0.505), {{nan, 0, 0}, {0, 0, 0}});
      follower.displacement(at(0.505), std::numeric_limits<double>::infinity());
      rig::JointReading broken;
      broken.wheel_rate = nan;
      follower.joints(at(0.505), broken);
      wrench(follower, 0.5);
      wire(follower, 0.3);
      follower.wrench(0, {});
    }
    ticks = ticks + follower.take();
  }
  EXPECT_EQ(follower.events().not_finite, 3u);
  EXPECT_EQ(follower.events().repeated, 2u);
  EXPECT_EQ(follower.events().time_zero, 1u);
  EXPECT_EQ(follower.events().jumps, 0u);
  ASSERT_EQ(ticks.size(), 101u);
  for (const Tick& tick : ticks) {
    ASSERT_TRUE(tick.wrench);
    EXPECT_TRUE(std::isfinite(tick.wrench->force.x()));
  }
}

TEST_F(FollowerTest, LoadIsTheMeasuredOneFiltered) {
  settings.load_filter = 0.1;
  Follower follower = make();
  std::vector<Tick> ticks;
  for (int ms = 0; ms <= 1000; ms += 10) {
    const double t = 1e-3 * ms;
    follower.wrench(at(t), {{0, 0, t < 0.495 ? 0.0 : 40.0}, {0, 0, 0}});
    wire(follower, t);
    joints(follower, t);
    ticks = ticks + follower.take();
  }
  // As long as the wheel hangs there is no prediction. Then the step response of a first-order filter from
  // the tick at 0.5 s on: 40 (1 - exp(-(n + 1) dt / tau)).
  EXPECT_EQ(follower.events().hanging, 50u);
  ASSERT_EQ(ticks.size(), 51u);
  EXPECT_EQ(ticks[0].stamp, at(0.5));
  EXPECT_EQ(ticks[0].motion.time, 0.0);
  EXPECT_NEAR(ticks[0].motion.load, 40.0 * (1.0 - std::exp(-0.1)), 1e-9);
  EXPECT_NEAR(ticks[9].motion.load, 40.0 * (1.0 - std::exp(-1.0)), 1e-9);
}

TEST_F(FollowerTest, TheTwinHasTheTemperatureOfTheRig) {
  Follower follower = make();
  follower.temperature(31.5);
  follower.temperature(nan);
  wrench(follower, 0.0);
  wire(follower, 0.0);
  joints(follower, 0.0);
  const auto ticks = follower.take();
  ASSERT_EQ(ticks.size(), 1u);
  EXPECT_EQ(ticks[0].motion.temperature, 31.5);
  EXPECT_EQ(follower.events().not_finite, 1u);
}

TEST_F(FollowerTest, GoesOnAfterTheTwinBroke) {
  Follower follower = make();
  const auto feed = [&](double t) {
    wrench(follower, t);
    wire(follower, t);
    joints(follower, t);
  };
  feed(0.0);
  seen.breaks = true;
  EXPECT_THROW(follower.take(), Error);
  seen.breaks = false;
  feed(0.01);
  EXPECT_EQ(follower.take().size(), 1u);
}

TEST_F(FollowerTest, RefusesImpossibleSettings) {
  settings.rate = 0.0;
  EXPECT_THROW(make(), Error);
}

}  // namespace
}  // namespace wheel_twin::nodes
