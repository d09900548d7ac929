// Explanations of an experiment: no effect, one effect or several, each fitted through the simulated rig to
// all channels and runs at once.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "twin/baseline.h"
#include "twin/fit.h"
#include "twin/fluctuation.h"
#include "twin/tones.h"

namespace wheel_twin::twin {

/// What a candidate is fitted to and judged by. Pointers are not owned.
struct Evidence {
  TwinConfig baseline;               ///< calibrated, without effects
  std::vector<Unknown> nuisance;     ///< baseline unknowns fitted along (no reference runs); empty: none
  Eigen::MatrixXd nuisance_columns;  ///< derivatives of all runs' residuals by them, in units of their
                                     ///< scales; empty: taken anew at every look
  std::vector<NoiseModel> noise;     ///< of each run
  double slow_freedom = 10.0;        ///< degrees of freedom that the slow noise of a run is known by
  FluctuationModel fluctuation;
  std::vector<LogDeviation> beyond;  ///< of each run: FluctuationModel::beyond; empty: nothing
  std::vector<const RunGrid*> runs;  ///< measured
  std::vector<std::vector<LogDeviation>> log_deviation;  ///< of each run, by stretch
  std::vector<LogDeviation> calm;  ///< of each run, as the baseline on an uneven bed has it
  std::vector<std::vector<double>>
      lag;  ///< of each run, by stretch: of the draw wire behind the wrench, s, less that of the references
  double lag_error = 0.05;  ///< of a stretch, s
  /// Of each run: reading of the draw wire at first touch, m, less that of the references; NaN: not known.
  std::vector<double> zero;
  double zero_error = 0.0;        ///< of a run, m
  std::vector<SharedTone> tones;  ///< that no reference run has
  /// Size of a feature of a channel (Finding) that the baseline leaves of the reference runs as well.
  std::map<std::pair<Channel, std::string>, double> left_of_references;

  FluctuationModel fluctuation_of(std::size_t run) const {
    FluctuationModel model = fluctuation;
    if (run < beyond.size()) model.beyond = beyond[run];
    return model;
  }
};

/// What the calibrated soil's uncertainty does to a candidate's residuals (soil_doubt.h): D^T D and D^T r.
/// Empty: not known.
struct Doubt {
  Eigen::MatrixXd information;
  Eigen::VectorXd slope;
};

struct Candidate {
  std::vector<std::string> effects;  ///< names; empty: nothing acts
  std::vector<std::vector<double>> values;
  std::vector<std::vector<double>> errors;  ///< standard errors
  std::vector<double> nuisance;             ///< values of the evidence's nuisance
  TwinConfig model;
  bool usable = false;
  bool fluctuates = false;  ///< it changes how much channels fluctuate, and is simulated on an uneven bed
  double chi_square = 0.0;  ///< of all residuals, time courses, fluctuations and lags
  std::vector<double> run_chi_square;  ///< by run
  Doubt doubt;
  double score = 0.0;  ///< log evidence: -chi_square / 2 less a price for each parameter told
  int parameters = 0;
  double told = 0.0;  ///< parameters, each as far as the data narrow its prior (MacKay 1992)
  std::shared_ptr<const Evidence> own;  ///< what it was fitted to, where not to everybody's (recalibration.h)
};

/// What `candidate` was fitted to, `shared` being everybody's.
inline const Evidence& evidence_of(const Candidate& candidate, const Evidence& shared) {
  return candidate.own ? *candidate.own : shared;
}

/// Residuals of one run under a model, whitened: the time course, then the fluctuation of the channels, then
/// the lag of the draw wire. With `with_fluctuation` the model runs on an uneven bed (several times the
/// cost), else its channels are taken to fluctuate as `held` says, by default as the baseline's. `block` as
/// for whiten.
std::vector<double> run_residuals(const Evidence& evidence, std::size_t run, const TwinConfig& model,
                                  bool with_fluctuation, std::vector<int>* block = nullptr,
                                  const LogDeviation* held = nullptr);

/// What the draw wire of a model reads when the wheel of `run` first touches the soil, less what it would
/// read without effects, m.
double zero_of(const TwinConfig& model, const RunGrid& run);

/// The same as chi-square over a choice of runs.
std::vector<double> chi_squares(const Evidence& evidence, const TwinConfig& model,
                                const std::vector<std::size_t>& runs, bool with_fluctuation);

/// Delay that the effects of a model put on the draw wire's stamps, s.
double draw_wire_delay(const TwinConfig& model);

/// Chi-square that a fit of `effects` would reach, as one Gauss-Newton step from the best of its starts
/// foretells it, `known` as for fit_candidate, known friction left out; infinite when no start can be
/// simulated, zero where friction to be found makes a step foretell nothing.
double foretold_chi_square(const Evidence& evidence, const std::vector<std::string>& effects,
                           const std::vector<std::size_t>& runs,
                           const std::vector<std::vector<double>>& known = {});

/// Begins every later fit at the nuisance that `nothing` found, and takes its derivatives there once.
void begin_nuisance_at(Evidence& evidence, const Candidate& nothing);

/// Fits `effects` on the chosen runs, starting from several places; `known` gives start values for leading
/// effects (those of a smaller candidate).
Candidate fit_candidate(const Evidence& evidence, const std::vector<std::string>& effects,
                        const std::vector<std::size_t>& runs,
                        const std::vector<std::vector<double>>& known = {}, int iterations = 12);

}  // namespace wheel_twin::twin
