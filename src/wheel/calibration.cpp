#include "wheel/calibration.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"

namespace wheel_twin::wheel {

double small_load(double radius, double flexural_rigidity) {
  return 1.0e-4 * 2.0 * radius * flexural_rigidity / (0.1488 * radius * radius * radius);
}

double printed_stiffness(int segments, double radius, double flexural_rigidity, double load) {
  const double W = load, R = radius, EI = flexural_rigidity;
  if (segments < 8 || segments % 4 != 0) {
    throw Error(
        fmt::format("the printed procedure takes a multiple of 4 and at least 8 segments, not {}", segments));
  }
  const double dD_H = 0.1366 * W * R * R * R / EI;
  const double dD_V = -0.1488 * W * R * R * R / EI;
  if (!(load > 0.0) || -dD_V > 0.15 * 2.0 * R) {
    throw Error(fmt::format("the printed procedure takes a load above 0 and at most {:.4g} N, not {:.4g}",
                            0.15 * 2.0 * R * EI / (0.1488 * R * R * R), load));
  }
  const double a = R + dD_H / 2.0;
  const double b = R + dD_V / 2.0;
  const int n = segments / 4;
  const double spacing = M_PI / (2.0 * n);
  const auto tangent = [&](int i) {
    return std::atan2(b * std::cos(i * spacing), -a * std::sin(i * spacing));
  };
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    const double dtheta = tangent(i + 1) - tangent(i) - spacing;
    sum += dtheta * dtheta;
  }
  const double U = W * W * R * R * R / EI * (M_PI / 16.0 - 1.0 / (2.0 * M_PI));  // Eq. 5
  return U / (4.0 * 0.5 * sum);
}

double bending_stiffness(const Sheet& sheet, Bending bending, double length) {
  const double nu = bending == Bending::plate ? sheet.poisson_ratio : 0.0;
  return sheet.flexural_rigidity() / ((1.0 - nu * nu) * length);
}

DiameterChange ring_under_opposite_loads(double radius, double flexural_rigidity, double load) {
  const double unit = load * radius * radius * radius / flexural_rigidity;
  return {-(M_PI / 4.0 - 2.0 / M_PI) * unit, (2.0 / M_PI - 0.5) * unit};
}

double ring_frequency(int n, double radius, double flexural_rigidity, double mass_per_length) {
  const double k = n;
  return k * (k * k - 1.0) / std::sqrt(k * k + 1.0) *
         std::sqrt(flexural_rigidity / (mass_per_length * std::pow(radius, 4)));
}

}  // namespace wheel_twin::wheel
