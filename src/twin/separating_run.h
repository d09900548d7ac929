// The run that would tell rival explanations apart: where, over slips, loads and steering angles that a rig
// can drive, their twins differ most against the scatter of a run.
#pragma once

#include <string>

#include "logs/experiment.h"
#include "twin/steady_selection.h"

namespace wheel_twin::twin {

/// A sentence, empty when no rival comes near the chosen explanation.
std::string separating_run(const logs::Experiment& experiment, const SteadyEvidence& evidence,
                           const Selection& selection, const SteadyRuns& runs);

}  // namespace wheel_twin::twin
