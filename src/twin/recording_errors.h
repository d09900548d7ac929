// Errors of recording, looked for before any physics: a unit, a sign, exchanged axes, a channel that stands
// still, a log that is not of the rig that was declared. Found against the declared speeds and the declared
// twin, whose first guess is good to tens of percent, and put right in the grids.
#pragma once

#include <string>
#include <vector>

#include "twin/run_grid.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

struct RecordingError {
  std::string what;  ///< "the z axis of the force is flipped"
  std::vector<std::string> runs;
};

/// Looks at runs of one kind (reference, measured) together, puts right what it finds and tells it. Channels
/// of the force come as Fx, Fy, Fz. Throws Error when every channel of the runs stands still.
std::vector<RecordingError> put_right(const std::vector<RunGrid*>& runs, const TwinConfig& declared);

/// Why a run is no log of what is declared of it (slip, load), empty when it may be.
std::string contradiction(const RunGrid& run);

/// Bins of the steady part: while wheel and carriage move at constant speeds.
int steady_bins_of(const RunGrid& run);

}  // namespace wheel_twin::twin
