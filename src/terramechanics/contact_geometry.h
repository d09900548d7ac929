// Where wheel and soil touch: entry, exit and deflection angles of a wheel with a flat patch (paper, Section
// 2, Figure 1). Angles from the vertical through the hub, positive ahead, rad; lengths in m.
//   cos(theta_d) = 1 - delta_d / R,   cos(theta_1) = cos(theta_d) - z / R,   cos(theta_2) = cos(theta_d) -
//   gamma z / R
// The exit angle is negative here. All differences are formed without cancellation, so that a sinkage of a
// nanometre is exact.
#pragma once

#include <algorithm>
#include <cmath>

namespace wheel_twin::terramechanics {

struct ContactGeometry {
  double R = 0.0;
  double z = 0.0;        ///< sinkage of the lowest part of the rim below the undisturbed surface
  double delta_d = 0.0;  ///< wheel deflection
  double theta_1 = 0.0;  ///< entry
  double theta_2 = 0.0;  ///< exit, at most -theta_d
  double theta_d = 0.0;  ///< half of the flat patch
  double theta_m = 0.0;  ///< of the largest normal stress
  double front = 0.0;    ///< theta_1 - theta_d
  double rear = 0.0;     ///< -theta_d - theta_2
};

/// Angle whose versine (1 - cos) is `versine`, 0 to 2.
inline double angle_of_versine(double versine) {
  return 2.0 * std::asin(std::sqrt(std::clamp(0.5 * versine, 0.0, 1.0)));
}

/// `peak` is theta_m / theta_1, 0 to 1. Needs z >= 0, delta_d >= 0, z + delta_d <= R, 0 <= gamma <= 1.
inline ContactGeometry contact_geometry(double R, double z, double delta_d, double gamma, double peak) {
  ContactGeometry g;
  g.R = R;
  g.z = z;
  g.delta_d = delta_d;
  g.theta_d = angle_of_versine(delta_d / R);
  g.theta_1 = angle_of_versine((delta_d + z) / R);
  const double exit = angle_of_versine((delta_d + gamma * z) / R);
  g.theta_2 = -exit;
  g.theta_m = peak * g.theta_1;
  // cos(a) - cos(b) = 2 sin((a + b) / 2) sin((b - a) / 2) gives the small difference of two large angles.
  const auto difference = [&](double larger, double depth) {
    const double s = 2.0 * R * std::sin(0.5 * (larger + g.theta_d));
    return s > 0.0 ? 2.0 * std::asin(std::min(1.0, depth / s)) : 0.0;
  };
  g.front = difference(g.theta_1, z);
  g.rear = difference(exit, gamma * z);
  return g;
}

}  // namespace wheel_twin::terramechanics
