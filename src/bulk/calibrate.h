// Calibration of the grains from bulk tests (the paper's bulk calibration, Section 5): which friction
// coefficient and shear modulus give the measured cohesion, angle of internal friction and angle of repose?
// Each quantity is a Gaussian process over (friction, log shear modulus); a new point is simulated where the
// posterior is likely and least known. Ends with a posterior on a grid: what the tests determine, and what
// they leave open. SI units, angles in rad.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml.h"
#include "dem/granular_soil.h"

namespace wheel_twin::bulk {

enum Quantity : std::size_t { cohesion, friction_angle, angle_of_repose_quantity };
constexpr std::size_t quantity_count = 3;
constexpr std::array<const char*, quantity_count> quantity_names = {"cohesion", "friction_angle",
                                                                    "angle_of_repose"};

struct Measured {
  double value = 0.0;
  double error = 0.0;  ///< standard error, above 0
};
using Measurements = std::array<std::optional<Measured>, quantity_count>;

/// Keys: cohesion, friction_angle, angle_of_repose, each {value, stderr}, all optional, at least one.
Measurements read_measurements(const yaml::Map& map);

struct GrainParameters {
  double friction = 0.0;
  double shear_modulus = 0.0;  ///< Pa
};

struct Evaluation {
  GrainParameters at;
  std::array<double, quantity_count> value{};  ///< NaN where the quantity was not simulated
};

struct CalibrationSettings {
  double lowest_friction = 0.1, highest_friction = 1.2;
  double lowest_modulus = 5e6, highest_modulus = 1e8;  ///< Pa
  int initial_points = 7;
  int largest_points = 16;  ///< simulated parameter sets at most
  std::uint64_t seed = 1;
};

struct Marginal {
  double mean = 0.0;
  double low = 0.0, high = 0.0;  ///< central 90 %
  bool determined = false;       ///< the 90 % interval is narrower than half of that of the prior
};

struct Calibration {
  std::vector<Evaluation> evaluations;
  GrainParameters best;                            ///< largest posterior
  std::array<double, quantity_count> predicted{};  ///< at the best point
  std::array<double, quantity_count>
      predicted_error{};  ///< standard error of the prediction, scatter between seeds included
  Marginal friction;
  Marginal log10_modulus;                                 ///< of the modulus in Pa
  double correlation = 0.0;                               ///< of the two in the posterior
  std::vector<double> grid_friction, grid_log10_modulus;  ///< axes of the posterior
  std::vector<double> posterior;                          ///< row by row, friction along a row; sums to 1
  std::string undetermined;                               ///< one or two sentences for a person
};

using Simulate = std::function<Evaluation(const GrainParameters&)>;

/// `known`: evaluations of an earlier run, which count. `done` is called after each new one.
Calibration calibrate(const Measurements& measured, const CalibrationSettings& settings,
                      const Simulate& simulate, std::vector<Evaluation> known = {},
                      const std::function<void(const std::vector<Evaluation>&)>& done = {});

/// The simulated bulk tests of one parameter set: direct shear at 20, 40 and 70 kPa with `shear_rate` (m/s),
/// and a heap of `heap_clumps` when the angle of repose was measured.
struct TestSettings {
  double shear_rate = 0.02;
  double travel = 0.0125;
  /// The paper's heap. A smaller one is flatter: 22.6 degrees with 2000 clumps where 8880 have 32.9.
  std::size_t heap_clumps = 8880;
  int threads = 1;
};
Simulate bulk_tests(const dem::GranularSoil& soil, const Measurements& measured,
                    const TestSettings& settings);

/// evaluations.csv, calibration.json and calibration.svg in `folder`.
void write_calibration(const std::string& folder, const dem::GranularSoil& soil, const Measurements& measured,
                       const Calibration& result);

}  // namespace wheel_twin::bulk
