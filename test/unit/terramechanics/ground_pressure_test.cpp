#include "terramechanics/ground_pressure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace wheel_twin::terramechanics {
namespace {

TEST(GroundPressure, PatchIsTheChordOfTheDeflectedCircle) {
  // Half chord, radius and radius less deflection: 3-4-5.
  EXPECT_NEAR(flat_patch_length(0.05, 0.02), 0.08, 1e-15);
  Wheel wheel;
  wheel.radius = 0.05;
  wheel.width = 0.1;
  wheel.stiffness = 1000.0;
  EXPECT_NEAR(hard_ground_pressure(wheel, 20.0), 20.0 / (0.1 * 0.08), 1e-9);
}

TEST(GroundPressure, SoftWheelIsFlexibleStiffWheelIsNot) {
  Wheel wheel;
  const Soil soil;
  EXPECT_FALSE(works_as_flexible(wheel, soil, 42.1));
  wheel.stiffness = 9000.0;
  EXPECT_TRUE(works_as_flexible(wheel, soil, 42.1));
  wheel.stiffness = 1e6;
  EXPECT_FALSE(works_as_flexible(wheel, soil, 42.1));
}

TEST(GroundPressure, CriticalPressureFollowsItsPowersOfLoadAndModulus) {
  Wheel wheel;
  Soil soil;
  soil.k_c = 0.0;
  soil.n = 0.8;
  const double p = critical_ground_pressure(wheel, soil, 50.0);
  EXPECT_NEAR(critical_ground_pressure(wheel, soil, 100.0) / p, std::pow(2.0, 1.6 / 2.6), 1e-12);
  soil.k_phi *= 2.0;
  EXPECT_NEAR(critical_ground_pressure(wheel, soil, 50.0) / p, std::pow(2.0, 1.0 / 2.6), 1e-12);
}

TEST(GroundPressure, RefusesWhatMakesNoSense) {
  Wheel wheel;
  Soil soil;
  soil.k_c = -1e9;
  EXPECT_THAT([&] { sinkage_modulus(wheel, soil); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("not positive")));
  wheel.stiffness = 100.0;
  EXPECT_THAT([&] { hard_ground_pressure(wheel, 42.1); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("beyond its radius")));
}

}  // namespace
}  // namespace wheel_twin::terramechanics
