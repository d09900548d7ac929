#include "rig/sample_clock.h"

#include <cmath>

namespace wheel_twin::rig {

double quantised(double value, double resolution) {
  if (resolution <= 0.0) return value;
  return std::round(value / resolution) * resolution + 0.0;  // + 0.0 makes -0 a plain 0
}

}  // namespace wheel_twin::rig
