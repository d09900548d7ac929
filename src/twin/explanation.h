// How well a candidate explains an experiment: what it leaves, on runs that were fitted and on runs held out,
// and whether it has what stood out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "twin/certify.h"
#include "twin/common_course.h"
#include "twin/gathering.h"

namespace wheel_twin::twin {

/// That what explains most and is plainly wrong still explains nothing.
inline constexpr double not_all = 0.2;

struct Explanation {
  Omnibus left;                        ///< what stands out of the residual still
  double ratio = 0.0;                  ///< worst error over noise floor, runs that were fitted
  double ratio_held_out = 0.0;         ///< the same, runs held out
  bool misleads = false;               ///< runs held out are further from it than from none
  bool of_soil = false;                ///< without reference runs it is but another soil
  std::optional<double> tone;          ///< Hz, where a machine hums
  std::optional<CommonCourse> common;  ///< what follows the clock in all runs
  bool stands = false;                 ///< what stood out most does so still
  std::vector<Finding> remains;        ///< what stands out of what is left (plain_features)
  double unexplained = 1.0;            ///< probability that it is no explanation

  bool refuted() const { return misleads || of_soil; }
};

class Weighing {
 public:
  /// Everything must outlive this. `count`: number of residuals.
  Weighing(const Gathering& gathering, const RunsByRole& runs, const Candidate& nothing,
           const Omnibus& omnibus, double count);

  Explanation operator()(const Candidate& candidate) const;

  /// Chi-square of the residual above what noise has.
  double excess() const { return excess_; }
  const std::vector<NoiseModel>& held_out_noise() const { return held_out_noise_; }

 private:
  const Evidence& evidence_;
  const RunsByRole& runs_;
  const Candidate& nothing_;
  const Omnibus& omnibus_;
  double count_, excess_;
  std::vector<NoiseModel> noise_;  ///< of the measured runs, as errors are judged by it
  std::vector<NoiseModel> held_out_noise_;
};

/// The features that stand out of `after`, the strongest first, but for those that soils of another form than
/// the twin's make (levels), that the effects of `model`, whose residual it is, may make (lags, and how much
/// channels fluctuate, which is foretold roughly; only friction shakes the load), and small leavings of what
/// stood out `before` (an effect's own form, not another effect).
std::vector<Finding> plain_features(const Omnibus& after, const Omnibus& before, const TwinConfig& model);

/// The strongest of `features` that stands in two runs alike, or is of all runs.
std::optional<Finding> systematic(const std::vector<Finding>& features);

/// Whether a feature stands out of `after` still, by more than half of what it did.
bool still_there(const Finding& feature, const Omnibus& after);

/// The most that a p-value allows an effect's probability to be, one against one: 1 / (1 - e p ln p), the
/// bound of Sellke, Bayarri and Berger (2001).
double most_probable(double p);

}  // namespace wheel_twin::twin
