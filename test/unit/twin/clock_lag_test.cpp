// Lag of the draw wire against reference runs, on made fluctuations of which it is known.
#include "twin/clock_lag.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/random.h"
#include "steady_run.h"

namespace wheel_twin::twin {
namespace {

/// A minute of a run whose displacement follows the wrench by `lag(time)` seconds, with noise of its own.
RunGrid run_with(double slip, std::uint64_t seed, const std::function<double(double)>& lag) {
  constexpr double step = 0.02;
  constexpr int n = 3000;
  Random random(seed);
  std::vector<double> common;
  double value = 0.0;
  for (int i = 0; i < n + 200; ++i) {
    value = 0.93 * value + random.normal();  // correlated over 0.3 s
    common.push_back(value);
  }
  run_log::RunLog log;
  log.epoch = 1.7e9;
  for (int i = 0; i < n; ++i) {
    const double time = i * step, at = i + 100 - lag(time) / step;
    const auto before = static_cast<std::size_t>(at);
    const double share = at - std::floor(at);
    const double late = common[before] * (1.0 - share) + common[before + 1] * share;
    log.ft.time.push_back(time);
    log.ft.force.emplace_back(-common[static_cast<std::size_t>(i) + 100] + 2.0 * random.normal(), 0.0, 42.0);
    log.ft.torque.emplace_back(0.0, 0.1 * random.normal(), 0.0);
    log.draw_wire.time.push_back(time);
    log.draw_wire.value.push_back(0.01 + 1e-4 * (late + random.normal()));
    log.joints.time.push_back(time);
    log.joints.carriage_velocity.push_back(i < 200 || i > 2900 ? 0.0 : 0.02);
    log.joints.wheel_rate.push_back(i < 200 || i > 2900 ? 0.0 : 0.3);
  }
  RunGrid grid = steady_run(slip, 42.1);
  grid.lag_curves = lag_curves(log);
  return grid;
}

/// What the wheel has without any clock being late, as it slips more.
double own_lag(double slip) {
  return 0.1 * slip - 0.02;
}

class ClockLagTest : public testing::Test {
 protected:
  ClockLag found(const std::function<double(double slip, double time)>& late) {
    grids_.clear();
    std::uint64_t seed = 1;
    for (const double slip : {0.0, 0.2, 0.4, 0.6})
      grids_.push_back(run_with(slip, ++seed, [&](double) { return own_lag(slip); }));
    for (const double slip : {0.0, 0.1, 0.3, 0.5, 0.6})
      grids_.push_back(run_with(slip, ++seed, [&](double time) { return own_lag(slip) + late(slip, time); }));
    std::vector<const RunGrid*> references, measured;
    for (std::size_t i = 0; i < grids_.size(); ++i) (i < 4 ? references : measured).push_back(&grids_[i]);
    return clock_lag(measured, references);
  }

  /// Mean of all stretches, s, and its standard error.
  static std::pair<double, double> mean_of(const ClockLag& lag) {
    double sum = 0.0, count = 0.0;
    for (const auto& run : lag.by_run)
      for (const double one : run) sum += one, count += 1.0;
    return {sum / count, lag.error / std::sqrt(count)};
  }

  std::vector<RunGrid> grids_;
};

TEST_F(ClockLagTest, IsFoundWhateverLagTheWheelHasOfItsOwn) {
  for (const double offset : {0.0, 0.07, -0.15}) {
    const auto [mean, error] = mean_of(found([&](double, double) { return offset; }));
    EXPECT_NEAR(mean, offset, 2.0 * error) << offset;
    EXPECT_LT(error, 0.015) << offset;
  }
}

TEST_F(ClockLagTest, IsNotTakenFromAHubThatIsLateByFits) {
  const ClockLag lag = found([](double, double time) { return 0.15 + 0.1 * std::sin(0.1 * time); });
  for (const auto& run : lag.by_run) EXPECT_TRUE(run.empty());
}

TEST_F(ClockLagTest, HasAMeanWhereItIsNoChance) {
  EXPECT_NEAR(found([](double, double) { return -0.15; }).mean(), -0.15, 0.03);
  EXPECT_EQ(found([](double, double) { return 0.0; }).mean(), 0.0);
  EXPECT_EQ(ClockLag{}.mean(), 0.0);
}

TEST(MaskAboutChanges, TakesTheWiresReadingsThatAreOfTheOtherSide) {
  const auto hub = static_cast<Eigen::Index>(index_of(Channel::hub_displacement));
  const auto masked = [&](double seconds) {
    RunGrid run = steady_run(0.2, 42.1, 30);  // bins of 0.5 s
    for (const int change : {9, 10}) run.measured.col(change).setConstant(std::nan(""));
    mask_about_changes(seconds, run);
    EXPECT_EQ(run.measured.row(0).array().isNaN().count(), 2) << "the other channels are not late";
    std::vector<int> bins;
    for (int i = 0; i < run.bins(); ++i)
      if (std::isnan(run.measured(hub, i))) bins.push_back(i);
    return bins;
  };
  EXPECT_EQ(masked(0.0), (std::vector<int>{9, 10}));
  EXPECT_EQ(masked(0.3), (std::vector<int>{9, 10, 11}));
  EXPECT_EQ(masked(-0.7), (std::vector<int>{7, 8, 9, 10}));
}

TEST_F(ClockLagTest, NeedsReferenceRuns) {
  found([](double, double) { return 0.1; });
  const ClockLag lag = clock_lag({&grids_[4], &grids_[5]}, {&grids_[0], &grids_[1]});
  ASSERT_EQ(lag.by_run.size(), 2U);
  EXPECT_TRUE(lag.by_run[0].empty());
}

}  // namespace
}  // namespace wheel_twin::twin
