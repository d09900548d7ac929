// Slip and the pair of speeds that makes it. Slip s = 1 - v/(R omega) for a driving wheel and R omega/v - 1
// for a braking one, -1 (locked) to 1 (spinning on the spot); v is the carriage's speed, whatever the
// steering angle.
#pragma once

#include <algorithm>
#include <cmath>

namespace wheel_twin::rig {

/// Speeds below this are rest, m/s.
constexpr double rest_speed = 1e-7;

/// Slip of a wheel whose carriage moves at `carriage_speed` and whose rim at `rim_speed`, m/s; 0 at rest.
inline double slip_ratio(double carriage_speed, double rim_speed) {
  const double faster = std::max(std::abs(carriage_speed), std::abs(rim_speed));
  if (faster < rest_speed) return 0.0;
  return std::clamp((rim_speed - carriage_speed) / faster, -1.0, 1.0);
}

struct Speeds {
  double carriage = 0.0;  ///< m/s
  double wheel = 0.0;     ///< rad/s
};

/// The speeds of a run: the faster of rim and carriage runs at `radius` times `wheel_speed`, the other makes
/// the slip. For a driving wheel, carriage = (1 - s) R omega (paper, Section 6.1); for a braking one, rim =
/// (1 + s) v.
inline Speeds speeds_of_slip(double slip, double wheel_speed, double radius) {
  if (slip >= 0.0) return {(1.0 - slip) * radius * wheel_speed, wheel_speed};
  return {radius * wheel_speed, (1.0 + slip) * wheel_speed};
}

}  // namespace wheel_twin::rig
