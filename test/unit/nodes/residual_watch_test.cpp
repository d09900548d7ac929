#include "nodes/residual_watch.h"

#include <gtest/gtest.h>

#include <cmath>

namespace wheel_twin::nodes {
namespace {

TEST(ResidualWatch, IsTheRootMeanSquareOfTheWindow) {
  ResidualWatch watch(4, 2.0);
  EXPECT_EQ(watch.rms(), 0.0);
  for (double r : {100.0, 1.0, -2.0, 3.0, -4.0}) watch.add(r);
  EXPECT_NEAR(watch.rms(), std::sqrt(30.0 / 4.0), 1e-12);  // the 100 has left the window
  EXPECT_TRUE(watch.exceeded());
  watch.clear();
  EXPECT_FALSE(watch.exceeded());
}

TEST(ResidualWatch, JudgesOnlyAFullWindow) {
  ResidualWatch watch(3, 1.0);
  watch.add(5.0);
  watch.add(5.0);
  EXPECT_FALSE(watch.exceeded());
  watch.add(5.0);
  EXPECT_TRUE(watch.exceeded());
}

}  // namespace
}  // namespace wheel_twin::nodes
