#include "bulk/line_fit.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace wheel_twin::bulk {

LineFit fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(std::min(x.size(), y.size()));
  if (n < 2) throw Error("line fit: at least two points are needed");
  double mean_x = 0.0, mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / n;
    mean_y += y[i] / n;
  }
  double sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += (x[i] - mean_x) * (x[i] - mean_x);
    sxy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  if (!(sxx > 0.0)) throw Error("line fit: all points have the same abscissa");
  LineFit fit;
  fit.slope = sxy / sxx;
  fit.intercept = mean_y - fit.slope * mean_x;
  if (n > 2) {
    double squares = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double residual = y[i] - fit.intercept - fit.slope * x[i];
      squares += residual * residual;
    }
    const double variance = squares / (n - 2.0);
    fit.slope_error = std::sqrt(variance / sxx);
    fit.intercept_error = std::sqrt(variance * (1.0 / n + mean_x * mean_x / sxx));
  }
  return fit;
}

}  // namespace wheel_twin::bulk
