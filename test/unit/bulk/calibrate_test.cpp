#include "bulk/calibrate.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "base/error.h"
#include "base/random.h"
#include "bulk/gaussian_process.h"

namespace wheel_twin::bulk {
namespace {

TEST(GaussianProcess, InterpolatesASmoothFunction) {
  Eigen::MatrixXd x(25, 2);
  Eigen::VectorXd y(25);
  const auto f = [](double a, double b) { return std::sin(2.0 * a) + 0.5 * b * b; };
  for (int i = 0; i < 25; ++i) {
    x.row(i) << (i % 5) / 4.0, (i / 5) / 4.0;
    y[i] = f(x(i, 0), x(i, 1));
  }
  const GaussianProcess process(x, y);
  for (const double a : {0.13, 0.55, 0.87})
    for (const double b : {0.2, 0.66}) {
      const Prediction p = process.predict(Eigen::Vector2d(a, b));
      EXPECT_NEAR(p.mean, f(a, b), 0.01);
      EXPECT_LT(p.variance, 0.02 * 0.02);
    }
  // Far away it knows that it does not know.
  EXPECT_GT(process.predict(Eigen::Vector2d(3.0, 3.0)).variance,
            100.0 * process.predict(Eigen::Vector2d(0.5, 0.5)).variance);
}

TEST(GaussianProcess, TellsNoiseFromSignal) {
  Random random(2);
  Eigen::MatrixXd x(60, 1);
  Eigen::VectorXd y(60);
  for (int i = 0; i < 60; ++i) {
    x(i, 0) = i / 59.0;
    y[i] = 2.0 * x(i, 0) + 0.1 * random.normal();
  }
  const GaussianProcess process(x, y);
  const double sigma = std::sqrt(process.noise_variance());
  EXPECT_GT(sigma, 0.07);
  EXPECT_LT(sigma, 0.14);
  const Prediction middle = process.predict(Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_NEAR(middle.mean, 1.0, 3.0 * std::sqrt(middle.variance));
  EXPECT_LT(std::sqrt(middle.variance), 0.05);
}

// Bulk behaviour as the paper describes it: the friction angle saturates with friction (Figure 6), the angle
// of repose even more (Figure 7), cohesion falls a little with the modulus.
Evaluation like_the_paper(const GrainParameters& p) {
  Evaluation e;
  e.at = p;
  e.value[friction_angle] = 0.4 + 0.42 * (1.0 - std::exp(-p.friction / 0.4));
  e.value[angle_of_repose_quantity] = 0.53 * (1.0 - std::exp(-p.friction / 0.15));
  e.value[cohesion] = 400.0 - 100.0 * std::log10(p.shear_modulus / 2e7);
  return e;
}

TEST(Calibrate, FindsWhatTheTestsDetermineInTensOfTests) {
  const GrainParameters truth{0.5, 3e7};
  const Evaluation at_truth = like_the_paper(truth);
  Measurements measured;
  measured[friction_angle] = Measured{at_truth.value[friction_angle], 0.01};
  measured[cohesion] = Measured{at_truth.value[cohesion], 10.0};
  int calls = 0;
  const Calibration c = calibrate(measured, {}, [&](const GrainParameters& p) {
    ++calls;
    return like_the_paper(p);
  });
  EXPECT_LE(calls, 16);
  EXPECT_NEAR(c.best.friction, truth.friction, 0.06);
  EXPECT_NEAR(std::log10(c.best.shear_modulus), std::log10(truth.shear_modulus), 0.1);
  EXPECT_TRUE(c.friction.determined);
  EXPECT_TRUE(c.log10_modulus.determined);
  EXPECT_LT(c.friction.low, truth.friction);
  EXPECT_GT(c.friction.high, truth.friction);
}

TEST(Calibrate, SaysWhatRemainsOpen) {
  // The angle of repose alone, where it has saturated, determines neither parameter (paper, Section 5.2).
  Measurements measured;
  measured[angle_of_repose_quantity] = Measured{0.53, 0.02};
  const Calibration c = calibrate(measured, {}, like_the_paper);
  EXPECT_FALSE(c.friction.determined);
  EXPECT_FALSE(c.log10_modulus.determined);
  EXPECT_NE(c.undetermined.find("Friction is not determined"), std::string::npos);
  EXPECT_NE(c.undetermined.find("shear modulus is not determined"), std::string::npos);
}

TEST(Calibrate, RunsTheHeapsItselfAndWritesWhatItFound) {
  // Three heaps of sixty clumps: far too few for an angle, enough for every step of the way.
  dem::GranularSoil soil;
  soil.clumps.shapes = {dem::make_clump("pair", {{{0, 0, 0}, 0.003}, {{0.003, 0, 0}, 0.003}})};
  soil.clumps.shares = {1.0};
  soil.clumps.smallest_size = 0.9;
  soil.clumps.largest_size = 1.1;
  Measurements measured;
  measured[angle_of_repose_quantity] = Measured{0.5, 0.05};
  CalibrationSettings settings;
  settings.initial_points = settings.largest_points = 3;
  TestSettings tests;
  tests.heap_clumps = 60;
  const Calibration c = calibrate(measured, settings, bulk_tests(soil, measured, tests));
  ASSERT_EQ(c.evaluations.size(), 3U);
  for (const Evaluation& e : c.evaluations) {
    EXPECT_GT(e.value[angle_of_repose_quantity], 0.0);
    EXPECT_LT(e.value[angle_of_repose_quantity], 0.9);
    EXPECT_TRUE(std::isnan(e.value[cohesion]));
  }
  EXPECT_NE(c.undetermined.find("shear modulus is not determined"), std::string::npos) << c.undetermined;
  const auto folder = std::filesystem::temp_directory_path() / ("calibrate_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  write_calibration(folder.string(), soil, measured, c);
  for (const char* file : {"evaluations.csv", "calibration.json", "calibration.svg"})
    EXPECT_GT(std::filesystem::file_size(folder / file), 100U) << file;
  std::filesystem::remove_all(folder);
}

TEST(Calibrate, GoesOnFromKnownEvaluations) {
  Measurements measured;
  measured[friction_angle] = Measured{0.7, 0.01};
  std::vector<Evaluation> kept;
  const Calibration whole =
      calibrate(measured, {}, like_the_paper, {}, [&](const std::vector<Evaluation>& e) { kept = e; });
  ASSERT_EQ(kept.size(), whole.evaluations.size());
  const std::vector<Evaluation> half(kept.begin(),
                                     kept.begin() + static_cast<std::ptrdiff_t>(kept.size()) / 2);
  const Calibration resumed = calibrate(measured, {}, like_the_paper, half);
  EXPECT_EQ(resumed.evaluations.size(), whole.evaluations.size());
  EXPECT_EQ(resumed.best.friction, whole.best.friction);
  EXPECT_EQ(resumed.posterior, whole.posterior);
}

TEST(Measurements, AreReadStrictly) {
  const Measurements m =
      read_measurements(yaml::parse_text("friction_angle: {value: 0.74, stderr: 0.02}\n", "m.yaml"));
  ASSERT_TRUE(m[friction_angle].has_value());
  EXPECT_FALSE(m[cohesion].has_value());
  EXPECT_EQ(m[friction_angle]->value, 0.74);
  EXPECT_THROW(read_measurements(yaml::parse_text("friction_angle: {value: 0.74, stderr: 0}\n", "m.yaml")),
               Error);
  EXPECT_THROW(read_measurements(yaml::parse_text("angle: {value: 0.74, stderr: 1}\n", "m.yaml")), Error);
}

}  // namespace
}  // namespace wheel_twin::bulk
