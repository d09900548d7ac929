// Bounded non-linear least squares (Ceres, Levenberg-Marquardt) on a residual that only a simulation can
// give.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace wheel_twin::twin {

/// One unknown. A finite `prior_deviation` adds the residual (x - prior) / prior_deviation.
struct Unknown {
  std::string name;
  double start = 0.0;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double scale = 1.0;  ///< its natural size: derivatives are taken over a thousandth of it
  double prior = 0.0;
  double prior_deviation = std::numeric_limits<double>::infinity();
};

/// Appends the residuals at x, always the same number; false when x cannot be simulated.
using ResidualFunction = std::function<bool(const std::vector<double>& x, std::vector<double>& residuals)>;

struct FitResult {
  bool usable = false;
  std::vector<double> x;
  std::vector<double> residuals;                          ///< at x, without the priors
  double cost = std::numeric_limits<double>::infinity();  ///< half the sum of squares, priors included
  Eigen::MatrixXd covariance;                             ///< of x, inverse of J^T J with the priors
};

FitResult least_squares(const std::vector<Unknown>& unknowns, const ResidualFunction& function,
                        int max_iterations = 20);

}  // namespace wheel_twin::twin
