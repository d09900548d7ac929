// Fits the catalogue to the residual, one effect on top of what is already known, and scores the explanations
// against one another.
#pragma once

#include <vector>

#include "twin/candidates.h"

namespace wheel_twin::twin {

class Tracing {
 public:
  /// `evidence` must outlive this; it may change in between (judge_again).
  Tracing(const Evidence& evidence, int threads);

  Candidate nothing() const;

  /// Every effect of the catalogue on top of `base`: a look at each, then a fit of those that promise most,
  /// best score first.
  std::vector<Candidate> every_effect(const Candidate& base) const;

  /// Chi-square under the noise as it is now known.
  void judge_again(Candidate& candidate) const;

  Candidate scored(Candidate candidate) const;

  /// Chi-square counts six channels that share one fluctuation, and what the model misses: scores are cooled
  /// by how far the best explanation is from chi-square one.
  void set_temperature(const Candidate& best);

  /// Number of residuals.
  double count() const;

 private:
  const Evidence& evidence_;
  int threads_;
  std::vector<std::size_t> runs_;
  double price_ = 3.0;  // of a parameter
  double temperature_ = 3.0;
};

}  // namespace wheel_twin::twin
