// A first guess while a rig still runs: which effect of the catalogue would explain best what a twin misses
// of one run so far. Fits, but certifies nothing: that takes several runs (diagnosis.h).
#pragma once

#include <optional>
#include <string>

#include "twin/noise.h"
#include "twin/run_grid.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

struct LikeliestEffect {
  std::string name;
  double explained = 0.0;  ///< share of what exceeds the noise, 0 to 1
};

/// `band` is what a good twin may miss of each channel. Nothing when no effect explains half of what exceeds
/// it. What shows in fluctuations only (friction) cannot be told from one run.
std::optional<LikeliestEffect> likeliest_effect(const TwinConfig& twin, const RunGrid& run,
                                                const NoiseModel& band);

}  // namespace wheel_twin::twin
