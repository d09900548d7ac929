// Straight line through points by least squares, with the standard errors of its two numbers.
#pragma once

#include <vector>

namespace wheel_twin::bulk {

struct LineFit {
  double intercept = 0.0, slope = 0.0;
  double intercept_error = 0.0, slope_error = 0.0;  ///< standard errors; 0 with two points
};

/// Throws Error with fewer than two points or when all x are equal.
LineFit fit_line(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace wheel_twin::bulk
