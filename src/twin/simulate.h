// A run of the twin, led by the measured motion of a log, on the grid of that run. Deterministic; the
// unevenness of a real bed is added on request, as one realisation of a random stiffness along the travel;
// such a run starts at the measured hub displacement.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "effects/acting.h"
#include "rig/ports.h"
#include "twin/run_grid.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

/// Granular unevenness: log-stiffness of the soil as a first-order process along the travel of rim and
/// carriage.
struct Unevenness {
  double deviation = 0.0;            ///< standard deviation of the log-stiffness
  double correlation_length = 0.01;  ///< m of travel
  std::uint64_t seed = 1;
};

using effects::Acting;
/// The effects of a twin.
Acting acting_effects(const TwinConfig& model);

using Predicted = Eigen::Matrix<double, channel_rows, Eigen::Dynamic>;

/// Every channel at every bin of `grid`, in SI units. Throws Error when soil and wheel cannot carry the load.
Predicted simulate(const TwinConfig& model, const RunGrid& grid,
                   const std::optional<Unevenness>& unevenness = std::nullopt);

/// Measured minus predicted: bins (NaN where nothing was measured) and the window means of the grid, in its
/// order.
struct Residual {
  Predicted bins;
  std::vector<double> windows;
};
Residual residual_of(const RunGrid& grid, const Predicted& predicted);

/// Mean of a predicted channel over a window, NaN when no bin lies inside.
double window_mean(const Predicted& predicted, const RunGrid& grid, const WindowMean& window);

}  // namespace wheel_twin::twin
