// Closing the loop: calibrate, predict, ask whether the residual is more than noise, trace it to effects,
// certify, decide, add the effect and predict again.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "twin/candidates.h"
#include "twin/certify.h"

namespace wheel_twin::twin {

struct DiagnosisOptions {
  double false_alarm_rate = 0.05;  ///< over the whole catalogue
  int threads = 2;
};

/// RMSE over time of a channel, measured against twin, on the common grid. SI.
struct ChannelError {
  double before = 0.0;
  double after = 0.0;
  double noise_floor = 0.0;  ///< what a perfect twin would still show
};
using Errors = std::map<Channel, ChannelError>;

struct Ranked {
  Candidate candidate;
  double p_value = 1.0;  ///< corrected for the number of candidates; 1 when it was not put to the test
  double probability = 0.0;
};

struct Diagnosis {
  std::string experiment;
  std::string verdict;  ///< no_residual, effect_found, unexplained
  std::vector<Ranked>
      candidates;         ///< most probable first; the found one leads when the verdict is effect_found
  TwinConfig before;      ///< calibrated baseline
  TwinConfig revised;     ///< with the effects found
  Omnibus omnibus;        ///< of the baseline's residual
  Omnibus left;           ///< of the revised twin's residual
  Errors error;           ///< all measured runs
  Errors held_out_error;  ///< runs never fitted; empty when there are none
  std::vector<std::string> held_out;
  std::vector<std::string> warnings;
  std::string evidence;
  std::vector<RunGrid> grids;  ///< of every run, for plots
};

/// Throws Error when the experiment cannot be diagnosed at all (no measured run, nothing measured in them).
Diagnosis diagnose(const logs::Experiment& experiment, const DiagnosisOptions& options = {});

}  // namespace wheel_twin::twin
