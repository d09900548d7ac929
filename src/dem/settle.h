// Lets a packing come to rest, and finds the friction at which it comes to rest at a wanted density (the
// paper lowers the friction of the raining clumps and restores it afterwards, Section 6.2).
#pragma once

#include <functional>

#include "dem/system.h"

namespace wheel_twin::dem {

struct SettleSettings {
  double shortest_time = 0.0;  ///< s, before rest is asked for: a cloud starts at rest and must fall first
  double longest_time = 0.5;   ///< s after the shortest one; a packing that still stirs then is quenched
  /// Settled when the kinetic energy is below this fraction of what all clumps would have after falling by
  /// `length`.
  double rest_fraction = 1e-5;
  double length = 0.003;  ///< m, a grain radius
  /// A few loose clumps rock and spin for seconds. To end that, all velocities are set to zero this often, 50
  /// steps apart, once the packing has settled: a stress wave crosses the bed in that time. 0: not at all.
  int quenches = 100;
};

/// Called after every block of steps; time in s since the start of settling.
using SettleObserver = std::function<void(double time)>;

/// Steps until rest. Returns the simulated time, s. Needs gravity. Throws Error when the packing still flows
/// at the longest time: kinetic energy above a thousand times the fraction.
double settle(System& system, const SettleSettings& settings, const SettleObserver& observer = {});

/// Friction between 0.004 and `highest` at which `density(friction)` is `target` within `tolerance`; density
/// falls with friction. Bracketed secant (Illinois). Throws Error when the target is out of reach, with the
/// reachable range.
double tune_friction(double target, double highest, double tolerance,
                     const std::function<double(double)>& density);

}  // namespace wheel_twin::dem
