#include "twin/plate_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/random.h"

namespace wheel_twin::twin {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double k_c = 4.0e4, k_phi = 2.0e6, n = 1.1;

PressCurve plate(double diameter, double factor, double exponent, double compliance = 0.0) {
  PressCurve curve;
  curve.name = "plate";
  curve.indenter = "plate";
  curve.diameter = diameter;
  for (int i = 1; i <= 400; ++i) {
    const double z = 0.03 * i / 400.0;
    const double force = 0.25 * pi * diameter * diameter * factor * (k_c / diameter + k_phi) *
                         std::pow(0.015, n) * std::pow(z / 0.015, exponent);
    curve.depth.push_back(z + compliance * force);
    curve.force.push_back(force);
  }
  return curve;
}

TEST(PlateFit, RecoversTheLawFromPlatesOfThreeSizes) {
  const PlateFit fit = fit_plates({plate(0.06, 1.0, n), plate(0.08, 1.0, n), plate(0.10, 1.0, n)}, 0.06);
  // The depths of a point are averaged over a 30th of the stroke: a curvature error below 1e-3.
  EXPECT_NEAR(fit.n.value, n, 2e-3);
  EXPECT_NEAR(fit.k_c.value / k_c, 1.0, 0.03);
  EXPECT_NEAR(fit.modulus(0.06) / (k_c / 0.06 + k_phi), 1.0, 0.01);
}

TEST(PlateFit, TakesTheRigsComplianceOffTheDepth) {
  constexpr double compliance = 1.2e-5;
  PressCurve floor;
  floor.name = "floor";
  floor.indenter = "rigid_floor";
  for (int i = 0; i <= 300; ++i) {
    floor.force.push_back(i);
    floor.depth.push_back(compliance * i);
  }
  const PlateFit fit =
      fit_plates({plate(0.06, 1.0, n, compliance), plate(0.10, 1.0, n, compliance), floor}, 0.06);
  ASSERT_TRUE(fit.compliance);
  EXPECT_NEAR(fit.compliance->value, compliance, 1e-9);
  EXPECT_NEAR(fit.n.value, n, 2e-3);
}

TEST(PlateFit, ErrorsAreThoseBetweenTests) {
  // Tests scatter by 10 % in pressure and 0.08 in the exponent: over many experiments the errors of n in
  // units of their standard error must have a spread of about one. 9 tests an experiment, so the spread
  // itself is known to 1/sqrt(2 40).
  Random random(7);
  double squares = 0.0;
  constexpr int experiments = 16;
  for (int e = 0; e < experiments; ++e) {
    std::vector<PressCurve> curves;
    for (int t = 0; t < 9; ++t)
      curves.push_back(
          plate(0.06 + 0.02 * (t % 3), std::exp(0.10 * random.normal()), n + 0.08 * random.normal()));
    const PlateFit fit = fit_plates(curves, 0.06);
    squares += std::pow((fit.n.value - n) / fit.n.standard_error, 2);
    EXPECT_NEAR(fit.between_tests_exponent, 0.08, 0.07);
  }
  EXPECT_GT(std::sqrt(squares / experiments), 0.5);
  EXPECT_LT(std::sqrt(squares / experiments), 1.6);
}

TEST(PlateFit, PlatesOfOneSizeCannotSeparateTheModuli) {
  const PlateFit fit = fit_plates({plate(0.06, 1.0, n), plate(0.06, 1.1, n)}, 0.06);
  EXPECT_FALSE(fit.separate);
  EXPECT_EQ(fit.k_c.value, 0.0);
  EXPECT_NEAR(fit.modulus(0.06) / (k_c / 0.06 + k_phi), std::sqrt(1.1), 0.01);
}

TEST(PlateFit, RefusesASingleTest) {
  EXPECT_THROW(fit_plates({plate(0.06, 1.0, n)}, 0.06), Error);
}

}  // namespace
}  // namespace wheel_twin::twin
