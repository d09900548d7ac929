// Finite-sample tests. An effect counts only when what it predicts for runs that it was not fitted to goes
// along with their residual: sign-flip test over blocks of time, by drawn flips, with Hoeffding's bound
// (1963) beyond what they resolve, so that no distribution is assumed beyond symmetry. The question "is there
// anything" is asked of every run's features with Bonferroni's correction.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "twin/candidates.h"

namespace wheel_twin::twin {

/// p-value of "the effect explains nothing": cross-fitted, each half of the runs predicted from the other
/// half.
double certify(const Evidence& evidence, const Candidate& nothing, const Candidate& candidate);

/// One feature of the residual that a perfect twin would not show.
struct Finding {
  std::string run;  ///< or "all runs"
  Channel channel = Channel::drawbar_pull;
  /// level, trend, fluctuation, turn (once a wheel turn), place, lag, zero (of a wire), tone (of a machine)
  std::string feature;
  double size = 0.0;               ///< in the unit of the channel (fluctuation: ratio; lag: s)
  double z = 0.0;                  ///< in standard errors
  double p = 1.0;                  ///< of noise alone, not corrected for the number of features asked
  std::optional<SharedTone> tone;  ///< what hums
};

struct Omnibus {
  double p = 1.0;                 ///< corrected for the number of features asked
  std::vector<Finding> findings;  ///< the strongest first
};

/// Asks the residual of `model` on the runs of the evidence; `fluctuates` as in Candidate.
Omnibus ask_residual(const Evidence& evidence, const TwinConfig& model, bool fluctuates);

}  // namespace wheel_twin::twin
