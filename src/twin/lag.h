// How far the draw wire's stamps lag behind those of the wrench, from the granular fluctuation that both
// show.
#pragma once

#include <optional>

#include "run_log/run_log.h"

namespace wheel_twin::twin {

struct Lag {
  double seconds = 0.0;      ///< positive: the draw wire's stamps are late
  double correlation = 0.0;  ///< magnitude at that lag
};

/// Peak of the cross-correlation of the displacement with pitch torque or drawbar pull (whichever it follows
/// closer) within +-3 s, level removed. Nothing when they have too little in common (correlation below 0.4).
std::optional<Lag> draw_wire_lag(const run_log::RunLog& log);

}  // namespace wheel_twin::twin
