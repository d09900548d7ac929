#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/random.h"
#include "bulk/angle_of_repose.h"
#include "bulk/line_fit.h"
#include "bulk/plate_sinkage.h"

namespace wheel_twin::bulk {
namespace {

// Anscombe (1973), first data set: y = 3.00 + 0.500 x with standard errors 1.125 and 0.118.
TEST(LineFit, AnscombesFirstQuartet) {
  const LineFit fit = fit_line({10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5},
                               {8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68});
  EXPECT_NEAR(fit.intercept, 3.000, 0.001);
  EXPECT_NEAR(fit.slope, 0.500, 0.001);
  EXPECT_NEAR(fit.intercept_error, 1.125, 0.001);
  EXPECT_NEAR(fit.slope_error, 0.118, 0.001);
}

TEST(LineFit, RefusesWhatHasNoLine) {
  EXPECT_THROW(fit_line({1.0}, {2.0}), Error);
  EXPECT_THROW(fit_line({1.0, 1.0}, {2.0, 3.0}), Error);
}

dem::HeightMap cone(double angle, double height, double x, double y, double roughness) {
  dem::HeightMap map;
  map.spacing = 0.002;
  map.columns = map.rows = 300;
  Random random(3);
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column) {
      const double r = std::hypot(column * map.spacing - x, row * map.spacing - y);
      const double h = height - r * std::tan(angle);
      map.height.push_back(h > 0.0 ? h + roughness * random.uniform(-1, 1) : std::nan(""));
    }
  return map;
}

TEST(ReposeFit, FindsTheAngleOfACone) {
  for (const double angle : {0.35, 0.52, 0.7}) {
    const ReposeProfile p = fit_repose(cone(angle, 0.12, 0.3, 0.29, 0.0), 0.3, 0.29, 0.006);
    EXPECT_NEAR(p.angle, angle, 0.003);
    // The mean height of a ring of grains as rough as 3 mm still has the cone's slope.
    EXPECT_NEAR(fit_repose(cone(angle, 0.12, 0.3, 0.29, 0.003), 0.3, 0.29, 0.006).angle, angle, 0.01);
  }
}

TEST(ReposeFit, RefusesABareFloor) {
  dem::HeightMap map = cone(0.5, 0.12, 0.3, 0.3, 0.0);
  for (double& h : map.height) h = std::nan("");
  EXPECT_THROW(fit_repose(map, 0.3, 0.3, 0.006), Error);
}

TEST(BekkerFit, RecoversTheModuliOfThreePlates) {
  const double n = 0.9, k_c = 1370.0, k_phi = 814000.0;
  std::vector<SinkageCurve> curves;
  for (const double diameter : {0.06, 0.08, 0.10}) {
    SinkageCurve c;
    c.diameter = diameter;
    for (int i = 0; i <= 40; ++i) {
      c.sinkage.push_back(0.0005 * i);
      c.pressure.push_back((k_c / (0.5 * diameter) + k_phi) * std::pow(c.sinkage.back(), n));
    }
    curves.push_back(c);
  }
  const SinkageResult result = fit_bekker(curves);
  EXPECT_NEAR(result.n, n, 1e-9);
  EXPECT_NEAR(result.k_c, k_c, 1e-6 * k_phi);
  EXPECT_NEAR(result.k_phi, k_phi, 1e-6 * k_phi);
  const SinkageResult one = fit_bekker({curves[1]});
  EXPECT_NEAR(one.k_phi, k_c / 0.04 + k_phi, 1e-6 * k_phi);
  EXPECT_EQ(one.k_c, 0.0);
}

}  // namespace
}  // namespace wheel_twin::bulk
