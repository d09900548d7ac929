// What runs have in common over time, on made residuals.
#include "twin/common_course.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/random.h"
#include "steady_run.h"

namespace wheel_twin::twin {
namespace {

/// Six runs whose displacement fluctuates by 0.2 mm, correlated over two bins, about levels of their own.
std::optional<CommonCourse> course_of(const std::function<double(int run, double time)>& more) {
  constexpr int rows = static_cast<int>(channel_count);
  Random random(4);
  std::vector<RunGrid> grids;
  std::vector<Residual> residuals;
  for (int r = 0; r < 6; ++r) {
    grids.push_back(steady_run(0.1 * r, 42.1));
    Predicted residual = Predicted::Zero(rows, grids.back().bins());
    double value = 0.0;
    for (int i = 0; i < grids.back().bins(); ++i) {
      value = 0.6 * value + 0.8 * random.normal();
      residual(3, i) = 1e-3 * r + 2e-4 * value + more(r, grids.back().time(i));
    }
    residuals.push_back({residual, {}});
  }
  std::vector<const RunGrid*> runs;
  for (const RunGrid& grid : grids) runs.push_back(&grid);
  return common_course(runs, residuals);
}

TEST(CommonCourse, AStaircaseOfAllRunsIsFoundAtItsSteepestStep) {
  const auto found =
      course_of([](int, double time) { return 4e-4 * std::floor(time / 9.0) + (time > 40.0 ? 8e-4 : 0.0); });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->channel, Channel::hub_displacement);
  EXPECT_LT(found->p, 0.01);
  EXPECT_GT(found->share, 2.0);
  EXPECT_NEAR(found->time, 40.0, 1.5);
  EXPECT_NEAR(found->change, 8e-4, 3e-4);
}

TEST(CommonCourse, WhatRunsFluctuateByIsNoneNorStepsAtTimesOfTheirOwn) {
  const auto none = course_of([](int, double) { return 0.0; });
  ASSERT_TRUE(none);
  EXPECT_LT(none->share, 0.4);
  const auto own = course_of(
      [](int run, double time) { return time > 12.0 + 7.0 * run ? (run % 2 == 0 ? 1e-3 : -1e-3) : 0.0; });
  ASSERT_TRUE(own);
  EXPECT_TRUE(own->p > 0.01 || own->share < 0.7) << own->p << " " << own->share;
}

}  // namespace
}  // namespace wheel_twin::twin
