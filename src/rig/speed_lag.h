// First-order lag of a speed controller, or of a deflection, integrated exactly over a step.
#pragma once

#include <cmath>

namespace wheel_twin::rig {

struct Lagged {
  double value = 0.0;     ///< at the end of the step
  double integral = 0.0;  ///< over the step
};

/// `value` follows `target` with time constant `lag` (s, 0: at once) for dt seconds.
inline Lagged follow_lag(double value, double target, double lag, double dt) {
  if (lag <= 0.0) return {target, target * dt};
  const double decay = std::exp(-dt / lag);
  return {target + (value - target) * decay, target * dt + (value - target) * lag * (1.0 - decay)};
}

}  // namespace wheel_twin::rig
