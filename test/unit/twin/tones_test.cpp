// Tones of machines against the fluctuation of grains.
#include "twin/tones.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"

namespace wheel_twin::twin {
namespace {

constexpr double rate = 50.0, span = 60.0;

/// A minute of logs whose channels fluctuate as a first-order autoregressive process with `keep`, deviation
/// one; the displacement has a tone on top and a trend.
run_log::RunLog log_of(double keep, double frequency, double amplitude, std::uint64_t seed) {
  Random random(seed);
  run_log::RunLog log;
  Eigen::Matrix<double, 6, 1> state = Eigen::Matrix<double, 6, 1>::Zero();
  for (int i = 0; i < static_cast<int>(rate * span); ++i) {
    const double t = i / rate;
    for (int c = 0; c < 6; ++c) state[c] = keep * state[c] + std::sqrt(1.0 - keep * keep) * random.normal();
    log.ft.time.push_back(t);
    log.ft.force.emplace_back(state[0], state[1], state[2]);
    log.ft.torque.emplace_back(0.0, state[3], 0.0);
    log.draw_wire.time.push_back(t);
    log.draw_wire.value.push_back(state[4] + 0.1 * t + amplitude * std::sin(2.0 * M_PI * frequency * t));
    log.joints.time.push_back(t);
    log.joints.wheel_effort.push_back(state[5]);
  }
  return log;
}

TEST(Tones, OfFluctuationThereAreNone) {
  int lines = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const double keep : {0.0, 0.9, 0.98})
      for (const auto& of_channel : tones_of(log_of(keep, 1.0, 0.0, seed), 0.0, span, 0.2))
        lines += static_cast<int>(of_channel.size());
  EXPECT_LE(lines, 12);  // 360 spectra, doubtful is p of a hundredth
}

TEST(Tones, HaveTheirFrequencyAndAmplitude) {
  for (const double frequency : {0.451, 4.779, 19.3}) {
    const Tones tones = tones_of(log_of(0.98, frequency, 1.4, 5), 0.0, span, 0.2);
    const std::vector<Tone>& lines = tones[index_of(Channel::hub_displacement)];
    ASSERT_FALSE(lines.empty()) << frequency;
    EXPECT_NEAR(lines.front().frequency, frequency, 0.2 / span);
    EXPECT_NEAR(lines.front().amplitude, 1.4, 0.14);
    EXPECT_LT(lines.front().p, 1e-6);
  }
}

TEST(Tones, CountWhenMostRunsShareThemAndNoReferenceHasThem) {
  std::vector<Tones> all;
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    all.push_back(tones_of(log_of(0.9, 2.3, seed <= 3 ? 1.0 : 0.0, seed), 0.0, span, 0.2));
  const auto run = [&](std::size_t i) { return RunTones{&all[i], 0.02, 0.3}; };
  const std::vector<RunTones> runs = {run(0), run(1), run(3)}, quiet = {run(4)}, loud = {run(2)};
  const std::vector<SharedTone> shared = shared_tones(runs, quiet, 0.3);
  ASSERT_EQ(shared.size(), 1u);
  EXPECT_EQ(shared[0].channel, Channel::hub_displacement);
  EXPECT_EQ(shared[0].follows, Follows::time);
  EXPECT_NEAR(shared[0].frequency, 2.3, 0.01);
  EXPECT_EQ(shared[0].runs, 2);
  EXPECT_TRUE(shared_tones(runs, loud, 0.3).empty()) << "a reference run has it as well";
  EXPECT_TRUE(shared_tones({run(0), run(3), run(4)}, {}, 0.3).empty()) << "one run of three has it";
  EXPECT_TRUE(shared_tones(runs, quiet, 0.9).empty()) << "less than nine tenths of the deviation";
}

TEST(Tones, OfABeltFollowTheTravel) {
  constexpr double period = 0.02;  // m
  std::vector<Tones> all;
  std::vector<double> speeds = {0.01, 0.02, 0.03};
  for (std::size_t i = 0; i < speeds.size(); ++i)
    all.push_back(tones_of(log_of(0.9, speeds[i] / period, 1.0, i + 1), 0.0, span, 0.2));
  std::vector<RunTones> runs;
  for (std::size_t i = 0; i < speeds.size(); ++i) runs.push_back({&all[i], speeds[i], 0.3});
  const std::vector<SharedTone> shared = shared_tones(runs, {}, 0.3);
  ASSERT_EQ(shared.size(), 1u);
  EXPECT_EQ(shared[0].follows, Follows::travel);
  EXPECT_NEAR(1.0 / shared[0].frequency, period, 0.02 * period);
}

TEST(Tones, AChannelThatTheLogLacksHasNone) {
  run_log::RunLog log = log_of(0.9, 2.0, 3.0, 1);
  log.ft.torque.clear();
  log.joints.wheel_effort.clear();
  const Tones tones = tones_of(log, 0.0, span, 0.2);
  EXPECT_TRUE(tones[index_of(Channel::pitch_torque)].empty());
  EXPECT_TRUE(tones[index_of(Channel::motor_effort)].empty());
  EXPECT_FALSE(tones[index_of(Channel::hub_displacement)].empty());
}

TEST(Tones, NothingOfAShortLog) {
  for (const auto& of_channel : tones_of(log_of(0.0, 2.0, 5.0, 1), 0.0, 3.0, 0.2))
    EXPECT_TRUE(of_channel.empty());
}

}  // namespace
}  // namespace wheel_twin::twin
