// The soil's pressure-sinkage law from plates pressed into it: p = (k_c / b + k_phi) z^n (Bekker), b the
// diameter of the plate (the smaller dimension of the print, as a wheel's width is), z the depth less what
// the rig itself gives way. Tests of one sand differ more than points of one test: each test has its own
// factor on the pressure and its own exponent about common ones (random effects, their spread estimated with
// the rest), and all uncertainties are those between tests.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "run_log/run_log.h"

namespace wheel_twin::twin {

/// Force against depth of one pressing, loading only, as measured.
struct PressCurve {
  std::string name;
  std::string group;
  std::string indenter;       ///< plate, wheel or rigid_floor
  double diameter = 0.0;      ///< of a plate, m
  std::vector<double> depth;  ///< m
  std::vector<double> force;  ///< N
};

/// Reads bag or CSV of every pressing of an experiment. Throws Error naming the file.
std::vector<PressCurve> read_press_curves(const logs::Experiment& experiment);

struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
};

struct PlateFit {
  Estimate k_c;    ///< N/m^(n+1); negative where larger plates meet more pressure at equal depth
  Estimate k_phi;  ///< N/m^(n+2)
  Estimate n;
  bool separate = true;          ///< false: plates of one size only, k_c is 0 by decree
  double reference_depth = 0.0;  ///< m
  double between_tests_pressure =
      0.0;  ///< standard deviation between tests of ln(pressure at reference_depth)
  double between_tests_exponent = 0.0;  ///< of the exponent
  double within_test = 0.0;             ///< rms of ln(force) about each test's own line
  std::optional<Estimate> compliance;   ///< of the rig, m/N, from the rigid floor; none: taken as 0
  struct Test {
    std::string name;
    double diameter = 0.0;
    double pressure = 0.0;  ///< own, at reference_depth, Pa
    double exponent = 0.0;  ///< own
  };
  std::vector<Test> tests;

  double modulus(double b) const { return k_c.value / b + k_phi.value; }  ///< N/m^(n+2)
  double relative_error_at_width =
      0.0;  ///< standard error of ln(modulus(b) z^n) at reference_depth and b of `width`
};

/// `width`: of the wheel that the soil is wanted for, m. Throws Error with fewer than two plate tests, or
/// when no modulus above 0 at that width comes out.
PlateFit fit_plates(const std::vector<PressCurve>& curves, double width);

/// The declared soil with k_c, k_phi and n of the fit.
terramechanics::Soil soil_of_fit(const terramechanics::Soil& declared, const PlateFit& fit);

}  // namespace wheel_twin::twin
