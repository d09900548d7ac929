// The paper's printed numbers (Section 7) with the shipped wheel and soil; what the paper leaves open is in
// their files.
#include <gtest/gtest.h>

#include "base/yaml.h"
#include "terramechanics/ground_pressure.h"
#include "terramechanics/wheel_on_soil.h"

namespace wheel_twin::terramechanics {
namespace {

constexpr double kLoad = 42.1;  // N, Table 3

double pull(double slip) {
  const std::string config = std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/";
  const Wheel wheel = read_wheel(yaml::parse_file(config + "wheels/amalia.yaml"));
  const Soil soil = read_soil(yaml::parse_file(config + "soils/mars_simulant.yaml"));
  return predict_steady_state(wheel, soil, kLoad, {slip, 0.0}).drawbar_pull;
}

TEST(PaperCurve, MeanPullAtSlipsFrom04To06) {
  const double mean = (pull(0.4) + pull(0.5) + pull(0.6)) / 3.0;
  // 18.99 N printed; K was chosen for it to four digits, which is 0.003 N.
  EXPECT_NEAR(mean, 18.99, 0.01);
  // 13.24 N measured, and the printed relative error of 43.43 %.
  EXPECT_NEAR(mean / 13.24 - 1.0, 0.4343, 0.001);
}

TEST(PaperCurve, PrintedErrorsAtLowSlipGiveARisingMeasuredCurve) {
  // The model errs by 0.77 % at 0.2 and 21.99 % at 0.3; taken as too high, the measured pulls implied by our
  // curve rise from 0.2 over 0.3 to the measured 13.24 N at 0.4 to 0.6. With the sign reversed at 0.3 they
  // would not.
  const double at_02 = pull(0.2) / 1.0077, at_03 = pull(0.3) / 1.2199;
  EXPECT_LT(at_02, at_03);
  EXPECT_LT(at_03, 13.24);
  EXPECT_GT(pull(0.3) / (1.0 - 0.2199), 13.24);
}

TEST(PaperCurve, CriticalPressureByHand) {
  // Eq. 1 at 42.1 N, n = 1: (k_c / b + k_phi)^(1/3) (3 W / (2 b sqrt(2 R)))^(2/3) = 94.112 * 165.36 Pa.
  const std::string config = std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/";
  const Wheel wheel = read_wheel(yaml::parse_file(config + "wheels/amalia.yaml"));
  const Soil soil = read_soil(yaml::parse_file(config + "soils/mars_simulant.yaml"));
  EXPECT_NEAR(critical_ground_pressure(wheel, soil, kLoad), 15562.0, 1.0);
}

}  // namespace
}  // namespace wheel_twin::terramechanics
