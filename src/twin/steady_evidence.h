// Words for what the residual of window means looks like.
#pragma once

#include <string>
#include <vector>

#include "twin/steady_report.h"
#include "twin/steady_runs.h"

namespace wheel_twin::twin {

/// Where along the slip the residual of a twin stands out of the scatter: mean of measured less twin by
/// channel and band of slip, the strongest first. `twin` picks the prediction.
std::string describe_by_slip(const std::vector<SteadyRow>& rows, const SteadyNoise& noise,
                             double SteadyRow::Value::*twin);

/// What the residual goes along with over the runs: load, steering angle, group; only what is beyond chance.
std::string describe_correlations(const std::vector<SteadyRow>& rows, const SteadyNoise& noise,
                                  double SteadyRow::Value::*twin);

}  // namespace wheel_twin::twin
