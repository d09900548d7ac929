// What a diagnosis looks at: the runs that can be explained, by role, the baseline calibrated on them, and
// the noise that a perfect twin would still leave.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "twin/baseline.h"
#include "twin/candidates.h"
#include "twin/clock_lag.h"
#include "twin/recording_errors.h"

namespace wheel_twin::twin {

/// Runs of one experiment. Pointers are not owned.
struct RunsByRole {
  std::vector<const RunGrid*> references;
  std::vector<const RunGrid*> measured;
  std::vector<const RunGrid*> held_out;  ///< never fitted, so that what is claimed can be scored on them
  ClockLag clock;                        ///< of the measured runs, against the reference runs
  std::vector<RecordingError> recording_errors;
  std::vector<std::string> warnings;

  /// Whether the reference runs are enough for a baseline; else it is fitted along with the effects.
  bool calibrated() const { return references.size() >= 2; }
  std::vector<const RunGrid*> judged() const;  ///< measured, then held out

  /// Gives up runs held out in which a twin that was not fitted to them sinks to its axle; tells of them.
  void keep_what_carries(const TwinConfig& twin);
};

/// Sorts out what can be explained and puts errors of recording right. Throws Error when most runs are no
/// logs of what is declared, or none is measured.
RunsByRole usable_runs(const std::string& experiment, const TwinConfig& declared,
                       std::vector<RunGrid>& grids);

class Gathering {
 public:
  /// `runs` must outlive this.
  Gathering(const TwinConfig& declared, const RunsByRole& runs, const NoiseFloor& floor);

  const Calibration& calibration() const { return calibration_; }
  /// As of open_soils; empty without reference runs.
  const std::vector<TwinConfig>& soils() const { return soils_; }
  const Evidence& evidence() const { return evidence_; }
  Evidence& evidence() { return evidence_; }

  /// Estimates the noise anew: each channel of a run has no more than what any of the explanations leaves.
  void take_noise_from(const std::vector<Candidate>& explanations);

  /// Noise of each of `runs`.
  std::vector<NoiseModel> noise_of(const std::vector<const RunGrid*>& runs) const;

 private:
  /// Runs and what a twin leaves of them.
  struct Left {
    std::vector<const RunGrid*> runs;
    std::vector<Residual> residuals;
  };

  void set_lags();
  void set_zeros();
  void set_tones();
  void set_left_of_references();

  const RunsByRole& runs_;
  NoiseFloor floor_;
  Calibration calibration_;
  std::vector<TwinConfig> soils_;
  std::map<const RunGrid*, std::array<double, channel_count>> left_open_;  ///< of levels, by the references
  std::array<Start, channel_count> starts_;                                ///< by the references
  Left references_;
  std::vector<Left> measured_;  ///< by each of the explanations that tell the noise
  Evidence evidence_;
};

}  // namespace wheel_twin::twin
