#include "nodes/rut.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

double height_at(const Rut& rut, double x) {
  return rut.height(
      static_cast<std::size_t>(std::lround((x - rut.settings().begin) / rut.settings().spacing)));
}

/// Rolls from x = 0 to `end` at constant sinkage without slip.
void roll_to(Rut& rut, double end, double sinkage) {
  for (double x = 0.0; x < end; x += 0.0005) rut.roll(x, sinkage, x / rut.settings().radius);
}

TEST(Rut, IsLeftAtTheSinkageLessTheRebound) {
  RutSettings settings;
  settings.rebound = 0.3;
  Rut rut(settings);
  roll_to(rut, 0.4, 0.02);
  // Exit angle of the paper: R (1 - cos theta_2) = gamma z, so the floor lies at -(1 - gamma) z. A column is
  // passed by the exit point within half a column of it, where the rim is at most spacing times sin(theta_2)
  // higher or lower.
  const double theta_2 = std::acos(1.0 - 0.3 * 0.02 / 0.09);
  for (double x : {0.1, 0.2, 0.3})
    EXPECT_NEAR(height_at(rut, x), -0.7 * 0.02, settings.spacing * std::sin(theta_2));
  EXPECT_EQ(height_at(rut, 0.8), 0.0);
  EXPECT_NEAR(rut.deepest(), 0.02, 1e-4);  // still under the wheel
}

TEST(Rut, UnderTheWheelTheSoilFollowsTheRim) {
  Rut rut(RutSettings{});
  rut.roll(0.3, 0.02, 0.0);
  const double R = rut.settings().radius;
  for (std::size_t i = 0; i < rut.size(); ++i) {
    const double along = rut.x(i) - 0.3;
    if (along > 0.0 && along < R * std::sin(std::acos(1.0 - 0.02 / R))) {
      EXPECT_NEAR(rut.height(i), -0.02 + R - std::sqrt(R * R - along * along), 1e-12);
    }
  }
}

TEST(Rut, ADeeperSecondPassDeepensAndAShallowerOneInFrontDoesNotRaise) {
  Rut rut(RutSettings{});
  rut.roll(0.3, 0.03, 0.0);
  const double before = height_at(rut, 0.33);
  rut.roll(0.3, 0.01, 0.0);
  EXPECT_EQ(height_at(rut, 0.33), before);
}

TEST(Rut, GrousersLeaveMarksOnePitchOfTravelApart) {
  RutSettings settings;
  settings.grousers = 24;
  settings.grouser_height = 0.007;
  settings.spacing = 0.001;
  Rut rut(settings);
  roll_to(rut, 0.5, 0.02);
  int marks = 0;
  for (std::size_t i = 0; i < rut.size(); ++i)
    if (rut.x(i) > 0.1 && rut.x(i) < 0.4 && rut.height(i) < -0.7 * 0.02 - 0.003) ++marks;
  // 0.3 m over a pitch of 2 pi R / 24 = 23.56 mm: 12.7 marks.
  EXPECT_GE(marks, 12);
  EXPECT_LE(marks, 13);
}

TEST(Rut, AWheelInTheAirOrOutsideTheBinLeavesNothing) {
  Rut rut(RutSettings{});
  rut.roll(0.3, 0.0, 0.0);
  rut.roll(0.3, -0.01, 1.0);
  rut.roll(5.0, 0.02, 2.0);
  rut.roll(-5.0, 0.02, 3.0);
  EXPECT_EQ(rut.deepest(), 0.0);
  RutSettings impossible;
  impossible.spacing = 0.0;
  EXPECT_THROW(Rut{impossible}, Error);
}

}  // namespace
}  // namespace wheel_twin::nodes
