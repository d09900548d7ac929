#include "dem/settle.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"

namespace wheel_twin::dem {

double settle(System& system, const SettleSettings& settings, const SettleObserver& observer) {
  constexpr int block = 100;
  double mass = 0.0;
  for (std::size_t i = 0; i < system.size(); ++i) mass += system.mass(i);
  const double threshold = settings.rest_fraction * mass * system.settings().gravity.norm() * settings.length;
  const double start = system.time();
  for (;;) {
    system.step(block);
    const double time = system.time() - start;
    if (observer) observer(time);
    if (time < settings.shortest_time) continue;
    const double kinetic = system.energy().kinetic;
    if (kinetic < threshold) break;
    if (time < settings.shortest_time + settings.longest_time) continue;
    if (kinetic > 1e3 * threshold)
      throw Error(
          fmt::format("packing: still flows after {:.2f} s: kinetic energy {:.3g} J, wanted below {:.3g} J",
                      time, kinetic, threshold));
    break;
  }
  for (int i = 0; i < settings.quenches; ++i) {
    system.stop_all();
    system.step(block / 2);
    if (observer) observer(system.time() - start);
  }
  return system.time() - start;
}

double tune_friction(double target, double highest, double tolerance,
                     const std::function<double(double)>& density) {
  double high = highest;
  double excess_high = density(high) - target;
  if (excess_high > tolerance)
    throw Error(fmt::format("packing density {:.3f} is out of reach: at friction {} it is already {:.3f}",
                            target, highest, excess_high + target));
  if (std::abs(excess_high) <= tolerance) return high;
  // Down by thirds until the packing is dense enough.
  double low = high;
  double excess_low = excess_high;
  while (excess_low < 0.0) {
    if (low < 0.01)
      throw Error(fmt::format("packing density {:.3f} is out of reach: at friction {:.3g} it is only {:.3f}",
                              target, low, excess_low + target));
    high = low;
    excess_high = excess_low;
    low /= 3.0;
    excess_low = density(low) - target;
    if (std::abs(excess_low) <= tolerance) return low;
  }
  int side = 0;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const double friction = (low * excess_high - high * excess_low) / (excess_high - excess_low);
    const double excess = density(friction) - target;
    if (std::abs(excess) <= tolerance || high - low < 1e-3) return friction;
    if (excess > 0.0) {
      low = friction;
      excess_low = excess;
      if (side == 1) excess_high *= 0.5;
      side = 1;
    } else {
      high = friction;
      excess_high = excess;
      if (side == -1) excess_low *= 0.5;
      side = -1;
    }
  }
  throw Error(fmt::format("packing density {:.3f}: no friction found that gives it", target));
}

}  // namespace wheel_twin::dem
