// What a diagnosis looks at: the runs that can be explained, by role, the baseline calibrated on them, and
// the noise that a perfect twin would still leave.
#pragma once

#include <string>
#include <vector>

#include "logs/experiment.h"
#include "twin/baseline.h"
#include "twin/candidates.h"
#include "twin/recording_errors.h"

namespace wheel_twin::twin {

/// Runs of one experiment. Pointers are not owned.
struct RunsByRole {
  std::vector<const RunGrid*> references;
  std::vector<const RunGrid*> measured;
  std::vector<const RunGrid*> held_out;  ///< never fitted, so that what is claimed can be scored on them
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
  const Evidence& evidence() const { return evidence_; }
  Evidence& evidence() { return evidence_; }

  /// Estimates the noise anew: what a good explanation leaves tells it better than what the baseline leaves.
  void take_noise_from(const TwinConfig& explanation);

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

  const RunsByRole& runs_;
  NoiseFloor floor_;
  Calibration calibration_;
  Left references_, measured_;
  Evidence evidence_;
};

}  // namespace wheel_twin::twin
