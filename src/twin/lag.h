// How far the draw wire's stamps lag behind those of the wrench, from the granular fluctuation that both
// show.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "run_log/run_log.h"

namespace wheel_twin::twin {

struct Lag {
  double seconds = 0.0;      ///< positive: the draw wire's stamps are late
  double correlation = 0.0;  ///< magnitude at that lag
};

/// Peak of the cross-correlation of the displacement with pitch torque or drawbar pull (whichever it follows
/// closer) within +-3 s, level removed. Nothing when they have too little in common (correlation below 0.4,
/// beyond a second 0.6).
std::optional<Lag> draw_wire_lag(const run_log::RunLog& log);

/// How displacement and wrench fluctuate together, by equal stretches of the run.
struct LagCurves {
  static constexpr double step = 0.02;  ///< s, between two lags
  /// Correlation of the displacement with pitch torque and with drawbar pull, at lags from -3 s to 3 s.
  std::vector<std::array<Eigen::VectorXd, 2>> stretches;
};

/// Nothing when the run is too short.
std::optional<LagCurves> lag_curves(const run_log::RunLog& log);

}  // namespace wheel_twin::twin
