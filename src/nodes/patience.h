// How long the sides of a lock-step wait for one another. The wheel, in the middle, notices first who stalls
// and tells the others; the ends wait a little longer, so that they name the right one.
#pragma once

namespace wheel_twin::nodes {

/// s, from the parameter `patience` of the node.
inline double end_patience(double patience) {
  return 1.5 * patience;
}
/// While a bed is being made.
inline double bed_patience(double patience) {
  return 120.0 * patience;
}

}  // namespace wheel_twin::nodes
