// What reference runs leave open of the soil, in the standard errors and scores of effects.
#include "twin/soil_doubt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/random.h"
#include "steady_run.h"
#include "twin/open_soils.h"

namespace wheel_twin::twin {
namespace {

/// Runs of `rig` with white noise of 0.2 N, 0.1 mm and 0.01 N m.
std::vector<RunGrid> runs_of(const TwinConfig& rig, const std::vector<double>& slips, std::uint64_t seed) {
  Random random(seed);
  std::vector<RunGrid> grids;
  for (const double slip : slips) {
    grids.push_back(steady_run(slip, 42.1, 60));
    RunGrid& grid = grids.back();
    grid.measured = simulate(rig, grid);
    for (int i = 0; i < grid.bins(); ++i)
      for (int c = 0; c < channel_rows; ++c)
        grid.measured(c, i) += (c < 3 ? 0.2 : c == 3 ? 1e-4 : 0.01) * random.normal();
  }
  return grids;
}

std::vector<const RunGrid*> pointers(const std::vector<RunGrid>& grids) {
  std::vector<const RunGrid*> runs;
  for (const RunGrid& grid : grids) runs.push_back(&grid);
  return runs;
}

TEST(SoilDoubt, WidensWhatDependsOnTheSoilAndLeavesTheSensorsAlone) {
  TwinConfig truth = declared_rig();
  truth.soil.k_phi *= 1.5;
  truth.soil.phi += 0.08;
  truth.soil.K *= 1.3;
  const std::vector<RunGrid> references = runs_of(truth, {0.0, 0.2, 0.4, 0.6}, 3);
  const Calibration calibration =
      calibrate(declared_rig(), pointers(references), NoiseFloor{0.02, 0.02, 0.02, 2e-5, 4e-4, 2e-3});
  truth.effects = {{"soil_cohesion", {800.0}}};
  const std::vector<RunGrid> measured = runs_of(truth, {0.1, 0.3, 0.5}, 4);
  Evidence evidence;
  evidence.baseline = calibration.model;
  evidence.runs = pointers(measured);
  evidence.noise.assign(measured.size(), calibration.noise);
  for (std::size_t r = 0; r < measured.size(); ++r) {
    evidence.log_deviation.emplace_back();
    evidence.calm.emplace_back();
    evidence.lag.emplace_back();
  }
  const SoilDoubt doubt(open_soils(declared_rig(), calibration, evidence.runs), evidence);
  Candidate cohesion = fit_candidate(evidence, {"soil_cohesion"}, {0, 1, 2});
  Candidate bias = fit_candidate(evidence, {"ft_bias"}, {0, 1, 2});
  ASSERT_TRUE(cohesion.usable && bias.usable);
  const double cohesion_error = cohesion.errors[0][0], bias_error = bias.errors[0][0];
  doubt.add_to(cohesion);
  doubt.add_to(bias);
  EXPECT_GT(cohesion.errors[0][0], 2.0 * cohesion_error);
  EXPECT_LT(cohesion.errors[0][0], 400.0);
  EXPECT_NEAR(bias.errors[0][0], bias_error, 0.02 * bias_error);
  EXPECT_GT(cohesion.doubt.information.trace(), 100.0 * bias.doubt.information.trace());
}

// Four reference runs at slips up to 0.6 tell a run between them, and little of one far beyond.
TEST(OpenSoils, LeaveLittleOpenBetweenReferenceRunsAndMuchBeyondThem) {
  const std::vector<RunGrid> references = runs_of(declared_rig(), {0.2, 0.3, 0.4, 0.5}, 3);
  const Calibration calibration =
      calibrate(declared_rig(), pointers(references), NoiseFloor{0.02, 0.02, 0.02, 2e-5, 4e-4, 2e-3});
  const std::vector<RunGrid> others = runs_of(declared_rig(), {0.3, 0.35, 0.0, 0.8}, 4);
  const std::vector<TwinConfig> soils = open_soils(declared_rig(), calibration, pointers(references));
  ASSERT_GT(soils.size(), 8u);
  const auto open = left_open(soils, pointers(references), pointers(others));
  const std::size_t pull = index_of(Channel::drawbar_pull);
  EXPECT_LT(open[0][pull], 0.02);
  EXPECT_LT(open[1][pull], 0.03);
  EXPECT_GT(open[2][pull], 5.0 * open[1][pull]);
  EXPECT_GT(open[3][pull], 2.0 * open[1][pull]);
}

TEST(OpenSoils, StepAwayFromBounds) {
  TwinConfig declared = declared_rig();
  declared.soil.gamma = 0.0;  // its lower bound, and runs that say so
  const std::vector<RunGrid> references = runs_of(declared, {0.0, 0.2, 0.4, 0.6}, 3);
  const Calibration calibration =
      calibrate(declared, pointers(references), NoiseFloor{0.02, 0.02, 0.02, 2e-5, 4e-4, 2e-3});
  const std::vector<TwinConfig> soils = open_soils(declared, calibration, pointers(references));
  double furthest = 0.0;
  for (const TwinConfig& soil : soils)
    furthest = std::max(furthest, soil.soil.gamma - soils.front().soil.gamma);
  const double error = std::sqrt(calibration.fit.covariance(7, 7));
  ASSERT_EQ(calibration.unknowns[7].name, "gamma");
  EXPECT_GT(furthest, 0.5 * error);
}

}  // namespace
}  // namespace wheel_twin::twin
