// What twins leave of measured runs, against the noise that a perfect one would leave, and whether that is
// enough of an explanation.
#pragma once

#include <vector>

#include "twin/channel_error.h"
#include "twin/noise.h"
#include "twin/run_grid.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

constexpr double good_enough = 1.3;    ///< error after over noise floor
constexpr double plainly_wrong = 2.0;  ///< error after over noise floor at which nothing is explained

/// Errors of two twins over `runs`; `noise` of each run.
Errors errors_of(const std::vector<const RunGrid*>& runs, const TwinConfig& before, const TwinConfig& after,
                 const std::vector<NoiseModel>& noise);

/// The same errors against the floors of other `noise` of their `runs`.
Errors with_floors_of(const std::vector<NoiseModel>& noise, const std::vector<const RunGrid*>& runs,
                      Errors errors);

/// The worst ratio of error to noise floor over the channels that the hidden cause disturbs: those that were
/// little above the floor before, and are no worse now, speak of the baseline.
double worst_ratio(const Errors& errors);

/// Squared error that is added, after less before, in squared noise floors, summed over the channels.
double added(const Errors& errors);

/// The least share of a disturbed channel's squared error that is gone.
double least_gone(const Errors& errors);

}  // namespace wheel_twin::twin
