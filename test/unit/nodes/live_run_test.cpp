#include "nodes/live_run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "logs/bag_reader.h"
#include "nodes/replay_twin.h"
#include "rig/semi_empirical_contact.h"

namespace wheel_twin::nodes {
namespace {

struct LiveRunTest : testing::Test {
  terramechanics::Wheel wheel;
  terramechanics::Soil soil;
  rig::RunSettings settings;
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("wheel_twin_live_run_" + std::to_string(getpid()));

  LiveRunTest() {
    std::filesystem::create_directories(folder);
    settings.conditions.slip = 0.3;
    settings.profile.travel = 0.02;
    settings.sensors.ft.noise.setConstant(0.02);
    settings.sensors.ft.rate = 500.0;
  }
  ~LiveRunTest() override { std::filesystem::remove_all(folder); }
  std::string bag() const { return (folder / "run.bag").string(); }
};

void append(run_log::RunLog& all, const run_log::RunLog& piece) {
  const auto join = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  join(all.ft.time, piece.ft.time);
  join(all.ft.force, piece.ft.force);
  join(all.draw_wire.time, piece.draw_wire.time);
  join(all.draw_wire.value, piece.draw_wire.value);
  join(all.joints.time, piece.joints.time);
  join(all.joints.wheel_effort, piece.joints.wheel_effort);
}

TEST_F(LiveRunTest, PiecesTogetherAreTheBag) {
  rig::SemiEmpiricalContact contact(wheel, soil);
  LiveRun run(settings, contact, {}, bag());
  EXPECT_EQ(run.phase(), Phase::lowering);
  run_log::RunLog all;
  std::set<Phase> phases;
  while (!run.done()) {
    append(all, run.advance(run.time() + 0.03, 1e9));
    phases.insert(run.phase());
  }
  EXPECT_EQ(phases.size(), 7u);  // every phase has been gone through
  EXPECT_FALSE(std::filesystem::exists(bag()));
  run.close();
  const run_log::RunLog read = logs::read_run_log(bag());
  ASSERT_EQ(read.ft.time.size(), all.ft.time.size());
  ASSERT_EQ(read.draw_wire.time.size(), all.draw_wire.time.size());
  ASSERT_EQ(read.joints.time.size(), all.joints.time.size());
  EXPECT_EQ(read.ft.force, all.ft.force);
  EXPECT_EQ(read.draw_wire.value, all.draw_wire.value);
  EXPECT_EQ(read.joints.wheel_effort, all.joints.wheel_effort);
}

TEST_F(LiveRunTest, BiasMakesTheLastReadingsZero) {
  rig::SemiEmpiricalContact contact(wheel, soil);
  LiveRun run(settings, contact, {}, "");
  EXPECT_FALSE(run.bias());
  while (run.phase() != Phase::dwell) run.advance(run.time() + 0.01, 1e9);
  run.advance(run.time() + 0.5, 1e9);
  EXPECT_NEAR(run.step().load.force_hub_rig.z(), 42.1, 0.5);
  ASSERT_TRUE(run.bias());
  const run_log::RunLog log = run.advance(run.time() + 0.2, 1e9);
  ASSERT_GT(log.ft.force.size(), 50u);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& force : log.ft.force) mean += force / static_cast<double>(log.ft.force.size());
  // Both means have the noise of a sample, 0.02 N, over the square root of 50 and 100 samples: 0.0035 N
  // together; 4 sigma.
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.014);
}

TEST_F(LiveRunTest, StopRampsDownAndEndsEarly) {
  settings.profile.travel = 0.7;
  rig::SemiEmpiricalContact contact(wheel, soil);
  LiveRun run(settings, contact, {}, "");
  while (run.phase() != Phase::steady) run.advance(run.time() + 0.05, 1e9);
  run.advance(run.time() + 0.5, 1e9);
  const double stopped = run.time();
  run.stop();
  while (!run.done()) run.advance(run.time() + 0.05, 1e9);
  EXPECT_LE(run.time(), stopped + settings.profile.ramp + settings.profile.rest + 0.01);
  EXPECT_NEAR(run.step().readings.joints.carriage_velocity, 0.0, 1e-4);
}

TEST_F(LiveRunTest, CutShortTheBagHoldsWhatWasThere) {
  rig::SemiEmpiricalContact contact(wheel, soil);
  std::size_t samples = 0;
  {
    LiveRun run(settings, contact, {}, bag());
    samples = run.advance(0.2, 1e9).ft.time.size();
    run.close();
  }
  EXPECT_EQ(logs::read_run_log(bag()).ft.time.size(), samples);
}

/// The twin that follows the rig it is a copy of predicts it: the residual is the noise of the sensors and
/// what the quasi-static replay leaves out.
TEST_F(LiveRunTest, ATwinThatFollowsItsOwnRigHasNoResidual) {
  settings.profile.travel = 0.1;
  rig::SemiEmpiricalContact contact(wheel, soil);
  LiveRun run(settings, contact, {}, "");
  RigSetup setup;
  setup.wheel = wheel;
  setup.soil = soil;
  setup.run = settings;
  Follower follower(FollowerSettings{}, std::make_unique<ReplayTwin>(setup));
  double squares = 0.0, worst_displacement = 0.0;
  std::size_t count = 0;
  while (!run.done()) {
    const auto log = run.advance(run.time() + 0.01, 1e9);
    const auto stamp = [&](double time) { return 1700000000000000000 + std::llround(time * 1e9); };
    for (std::size_t i = 0; i < log.ft.time.size(); ++i)
      follower.wrench(stamp(log.ft.time[i]), {log.ft.force[i], log.ft.torque[i]});
    for (std::size_t i = 0; i < log.draw_wire.time.size(); ++i)
      follower.displacement(stamp(log.draw_wire.time[i]), log.draw_wire.value[i]);
    const auto& j = log.joints;
    for (std::size_t i = 0; i < j.time.size(); ++i)
      follower.joints(stamp(j.time[i]), {j.carriage_position[i], j.carriage_velocity[i], j.wheel_angle[i],
                                         j.wheel_rate[i], j.wheel_effort[i]});
    for (const Tick& tick : follower.take()) {
      if (run.phase() != Phase::steady || tick.motion.carriage_position < 0.05) continue;
      const double residual = tick.wrench->force.x() - tick.twin.readings.wrench.force.x();
      squares += residual * residual;
      worst_displacement =
          std::max(worst_displacement, std::abs(*tick.displacement - tick.twin.readings.displacement));
      ++count;
    }
  }
  ASSERT_GT(count, 100u);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.1);  // N, of about 20; the noise alone is 0.02
  EXPECT_LT(worst_displacement, 2e-4);                              // m, of about 0.015
}

}  // namespace
}  // namespace wheel_twin::nodes
