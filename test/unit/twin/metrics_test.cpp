#include "twin/metrics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace wheel_twin::twin {
namespace {

RunComparison run_with(double slip, double steering, double measured, double twin) {
  RunComparison run;
  run.run.slip = slip;
  run.run.steering_angle = steering;
  run.run.load = 25.0;
  ChannelComparison channel;
  channel.mean = {measured, twin};
  channel.error = std::abs(twin - measured);
  channel.from_average = true;
  run.channels[index_of(Channel::drawbar_pull)] = channel;
  return run;
}

bool any(const logs::Run&) {
  return true;
}

TEST(Metrics, RootMeanSquareAndMeanOfKnownResiduals) {
  const std::vector<RunComparison> runs = {run_with(0.1, 0.0, 1.0, 4.0), run_with(0.5, 0.0, 2.0, -2.0)};
  const auto error = error_of(runs, Channel::drawbar_pull, any);
  ASSERT_TRUE(error);
  EXPECT_DOUBLE_EQ(error->rmse, std::sqrt((9.0 + 16.0) / 2.0));
  EXPECT_DOUBLE_EQ(error->mean, (3.0 - 4.0) / 2.0);
  EXPECT_EQ(error->runs, 2U);
  EXPECT_FALSE(error_of(runs, Channel::hub_displacement, any))
      << "a channel that nobody measured has no error";
}

TEST(Metrics, FiltersTakeSteeringAndSlip) {
  const std::vector<RunComparison> runs = {run_with(-0.5, 0.0, 0.0, 1.0), run_with(0.5, 0.0, 0.0, 2.0),
                                           run_with(0.5, 0.26, 0.0, 5.0)};
  EXPECT_EQ(error_of(runs, Channel::drawbar_pull, is_straight)->runs, 2U);
  EXPECT_DOUBLE_EQ(error_of(runs, Channel::drawbar_pull,
                            [](const logs::Run& r) { return is_straight(r) && is_driving(r); })
                       ->rmse,
                   2.0);
}

TEST(Metrics, BestConstantIsTheSpreadOfTheMeasured) {
  const std::vector<RunComparison> runs = {run_with(0.1, 0.0, 1.0, 0.0), run_with(0.5, 0.0, 5.0, 0.0)};
  EXPECT_NEAR(*error_of_constant(runs, Channel::drawbar_pull, any), 2.0, 1e-12);
}

TEST(Metrics, ScatterOfRepeatedRunsIsPooledOverConditions) {
  // Two conditions with two and three runs, squared deviations 0.5 and 2, degrees of freedom 1 and 2; one run
  // alone.
  const std::vector<RunComparison> runs = {run_with(0.50, 0.0, 1.0, 0.0),  run_with(0.505, 0.0, 2.0, 0.0),
                                           run_with(-1.0, 0.0, 10.0, 0.0), run_with(-1.0, 0.0, 11.0, 0.0),
                                           run_with(-1.0, 0.0, 12.0, 0.0), run_with(0.2, 0.0, 99.0, 0.0)};
  const auto scatter = repeat_scatter(runs, Channel::drawbar_pull, any);
  ASSERT_TRUE(scatter);
  EXPECT_NEAR(scatter->std, std::sqrt((0.5 + 2.0) / 3.0), 1e-12);
  EXPECT_EQ(scatter->runs, 5U);
  EXPECT_EQ(scatter->conditions, 2U);

  // A reference run and a measured one differ by what was changed on the rig between them.
  std::vector<RunComparison> changed = {run_with(0.5, 0.0, 1.0, 0.0), run_with(0.5, 0.0, 2.0, 0.0)};
  changed[0].run.role = logs::Role::reference;
  EXPECT_FALSE(repeat_scatter(changed, Channel::drawbar_pull, any));
}

}  // namespace
}  // namespace wheel_twin::twin
