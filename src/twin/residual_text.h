// What a diagnosis says of a residual, in words for the person who has to check the rig or write the missing
// effect.
#pragma once

#include <string>
#include <vector>

#include "twin/certify.h"
#include "twin/recording_errors.h"

namespace wheel_twin::twin {

/// "a + b"; "nothing" where there is none.
std::string effect_list(const std::vector<std::string>& names);

/// The strongest findings.
std::string describe(const Omnibus& omnibus);

/// "5.3 Hz", or what else the tone follows.
std::string frequency_of(const SharedTone& tone);

/// Channels whose level follows slip over the runs, each after "; ".
std::string correlations(const Evidence& evidence, const TwinConfig& model);

/// What was put right before any physics, as a sentence; empty when nothing was.
std::string told(const std::vector<RecordingError>& errors);

}  // namespace wheel_twin::twin
