// How late the draw wire's stamps are in the measured runs against the reference runs. Wire and wrench
// fluctuate together at lags of their own, which differ with slip and load: the cross-correlation of a
// measured run is compared with that of the reference runs nearest to it, shifted. How far the answer can be
// trusted is what stretches of the runs, and reference runs among themselves, scatter by.
#pragma once

#include <vector>

#include "twin/run_grid.h"

namespace wheel_twin::twin {

struct ClockLag {
  std::vector<std::vector<double>> by_run;  ///< of each stretch of each run, s; positive: the wire is late
  double error = 0.0;  ///< standard error of a stretch, s: that of the mean of all is smaller by the root of
                       ///< their number, and holds the error of the zero

  /// Mean of all stretches, where it is no chance; else none.
  double mean() const;
};

/// Needs three reference runs. Without them, without measured runs that are long enough, and where the
/// stretches of a run are late by different times (friction holds the slide), `by_run` holds no stretch.
ClockLag clock_lag(const std::vector<const RunGrid*>& measured,
                   const std::vector<const RunGrid*>& references);

/// Takes the wire's readings about changes of speed out of a run whose wire is late by `seconds` (early,
/// where negative): beside them it shows at rest how the wheel moves, and in motion how it stood.
void mask_about_changes(double seconds, RunGrid& run);

}  // namespace wheel_twin::twin
