// A twin on an experiment that it has not seen: errors only, nothing is fitted.
#pragma once

#include <string>

#include "logs/experiment.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

/// The text of evaluation.json. Runs that the twin cannot carry are listed with the reason and count in no
/// error; the RMSE is over runs: each run's error is the RMSE over time while moving, or the difference of
/// means over its window. `error` is of all runs, `error_straight` of those at steering angle 0,
/// `error_straight_driving` of those of them above slip 0.05. Throws Error when no run can be evaluated.
std::string evaluate(const TwinConfig& twin, const logs::Experiment& experiment);

}  // namespace wheel_twin::twin
