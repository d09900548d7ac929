// A run of the twin along a measured motion that ends badly.
#include "twin/simulate.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "steady_run.h"
#include "twin/gathering.h"

namespace wheel_twin::twin {
namespace {

// A soil that slip loosens carries the wheel at slip 0.2 and not at slip 1, which the last bins have: the
// carriage stops before the wheel.
TEST(Simulate, AWheelDoesNotSinkToItsAxleWhereSpeedsChange) {
  TwinConfig twin;
  twin.effects = {{"slip_loosening", {20.0, 1.0, 1.0}}};
  RunGrid grid = steady_run(0.2, 42.1, 60);
  const Predicted expected = simulate(twin, grid);
  for (int i = 55; i < grid.bins(); ++i) grid.motion[static_cast<std::size_t>(i)].carriage_velocity = 0.0;
  EXPECT_THROW(simulate(twin, grid), Error) << "slip 1 was measured";
  for (int i = 55; i < grid.bins(); ++i) grid.moving[static_cast<std::size_t>(i)] = false;
  const Predicted masked = simulate(twin, grid);
  EXPECT_TRUE(masked.leftCols(55).isApprox(expected.leftCols(55), 1e-9));
  EXPECT_NEAR(masked(3, 58), expected(3, 58), 1e-4);
}

// What a twin says of a run that it was not fitted to can be nothing at all.
TEST(RunsByRole, GiveUpRunsHeldOutThatTheTwinCannotCarry) {
  TwinConfig twin;
  twin.effects = {{"slip_loosening", {20.0, 1.0, 1.0}}};
  const RunGrid carried = steady_run(0.2, 42.1, 60);
  RunGrid sinking = steady_run(1.0, 42.1, 60);
  sinking.name = "run_7.bag";
  RunsByRole runs;
  runs.held_out = {&carried, &sinking};
  runs.keep_what_carries(twin);
  EXPECT_EQ(runs.held_out, std::vector<const RunGrid*>{&carried});
  ASSERT_EQ(runs.warnings.size(), 1U);
  EXPECT_NE(runs.warnings.front().find("run_7.bag"), std::string::npos);
}

}  // namespace
}  // namespace wheel_twin::twin
