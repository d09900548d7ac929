// Which bins of a log speak of a wheel at rest, and how differently wheels stand.
#include "twin/run_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "steady_run.h"
#include "twin/noise.h"

namespace wheel_twin::twin {
namespace {

/// 40 s at 50 Hz: the wheel settles by `settling` of its sinkage until 5 s, stands, and takes up speed evenly
/// from 10.4 to 12 s.
RunGrid starting_slowly(double settling) {
  constexpr double radius = 0.09, rate = 0.3, slip = 0.2;
  run_log::RunLog log;
  log.epoch = 1.7e9;
  double angle = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.02 * i;
    const double speed = rate * std::clamp((t - 10.4) / 1.6, 0.0, 1.0);
    angle += 0.02 * speed;
    log.ft.time.push_back(t);
    log.ft.force.emplace_back(speed > 0.0 ? 5.0 : 0.0, 0.0, 42.1);
    log.ft.torque.emplace_back(0.0, 0.0, 0.0);
    log.draw_wire.time.push_back(t);
    log.draw_wire.value.push_back(0.01 * (t < 5.0 ? 1.0 - settling : 1.0));
    log.joints.time.push_back(t);
    log.joints.wheel_rate.push_back(speed);
    log.joints.wheel_angle.push_back(angle);
    log.joints.carriage_velocity.push_back((1.0 - slip) * radius * speed);
    log.joints.carriage_position.push_back((1.0 - slip) * radius * angle);
  }
  logs::Run declared;
  declared.slip = slip;
  declared.load = 42.1;
  declared.wheel_speed = rate;
  GridOptions options;
  options.bin = 0.5;
  return grid_of(declared, "run", log, radius, options);
}

bool measured_at(const RunGrid& grid, double time) {
  return std::isfinite(grid.measured(2, static_cast<int>(time / grid.bin)));
}

TEST(RunGrid, ABinInWhichTheWheelBeginsToMoveIsNotAtRest) {
  const RunGrid grid = starting_slowly(0.0);
  EXPECT_TRUE(measured_at(grid, 9.75));
  EXPECT_FALSE(measured_at(grid, 10.25)) << "0.6 % of the speed in the mean, yet not at rest";
  EXPECT_FALSE(measured_at(grid, 10.75));
  EXPECT_TRUE(measured_at(grid, 20.25));
  EXPECT_TRUE(grid.moving[40]);
  EXPECT_FALSE(grid.moving[20]);
}

TEST(RunGrid, AWheelThatStillSettlesIsNotAtRest) {
  EXPECT_TRUE(measured_at(starting_slowly(0.005), 4.25));
  EXPECT_FALSE(measured_at(starting_slowly(0.02), 4.25));
  EXPECT_TRUE(measured_at(starting_slowly(0.02), 5.25));
}

TEST(ScatterAtRest, IsTakenAboutTheMedian) {
  std::vector<RunGrid> grids;
  std::vector<Residual> residuals;
  for (const double level : {5.0, 6.0, 10.0}) {
    grids.push_back(steady_run(0.2, 42.1, 60));
    grids.back().measured.setZero();
    residuals.push_back({Predicted::Constant(channel_rows, 60, level), {}});
  }
  const std::vector<const RunGrid*> runs = {&grids[0], &grids[1], &grids[2]};
  EXPECT_NEAR(scatter_at_rest(runs, residuals)[0], 1.4826, 1e-12);
  EXPECT_EQ(scatter_at_rest({&grids[0], &grids[1]}, {residuals[0], residuals[1]})[0], 0.0);
}

}  // namespace
}  // namespace wheel_twin::twin
