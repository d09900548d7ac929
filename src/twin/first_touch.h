// Where the wheel meets the soil as it is let down: what the draw wire reads there tells an offset of it from
// whatever comes with load or depth.
#pragma once

#include <optional>

#include "run_log/run_log.h"

namespace wheel_twin::twin {

struct FirstTouch {
  double displacement = 0.0;  ///< reading of the draw wire when the load first shows, m
  double speed = 0.0;         ///< of lowering, m/s
};

/// Nothing when the log does not begin with a wheel that hangs free and is let down.
std::optional<FirstTouch> first_touch(const run_log::RunLog& log);

}  // namespace wheel_twin::twin
