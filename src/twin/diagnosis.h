// Closing the loop: calibrate, predict, ask whether the residual is more than noise, trace it to effects,
// certify, decide, add the effect and predict again.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "twin/candidates.h"
#include "twin/certify.h"
#include "twin/channel_error.h"
#include "twin/recording_errors.h"
#include "twin/steady_report.h"

namespace wheel_twin::twin {

struct DiagnosisOptions {
  double false_alarm_rate = 0.05;  ///< over the whole catalogue
  int threads = 2;
  /// Runs known by means: choose the effects anew without each group left out. Costs as many diagnoses as
  /// there are groups; false: only their parameters are fitted anew.
  bool choose_without_group = true;
};

struct Ranked {
  Candidate candidate;
  double p_value = 1.0;  ///< corrected for the number of candidates; 1 when it was not put to the test
  double probability = 0.0;
};

/// What a person should look at on the rig because of an effect.
struct Check {
  std::string effect;
  std::string what;
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
  std::vector<RecordingError> recording_errors;  ///< found and put right before any physics
  std::string evidence;
  std::vector<Check> checks;                         ///< of the effects that `evidence` speaks for
  std::map<std::string, double> effect_probability;  ///< where it is not that of the leading candidate
  std::vector<RunGrid> grids;                        ///< of every run, for plots
  std::optional<SteadyReport> steady;                ///< runs known by window means only
};

/// Throws Error when the experiment cannot be diagnosed at all (no measured run, nothing measured in them).
Diagnosis diagnose(const logs::Experiment& experiment, const DiagnosisOptions& options = {});

}  // namespace wheel_twin::twin
