// The verdict of a diagnosis and its grounds, in words for the person who has to check the rig.
#pragma once

#include <string>
#include <vector>

#include "twin/diagnosis.h"
#include "twin/explanation.h"

namespace wheel_twin::twin {

/// What the words are made of beside the diagnosis itself.
struct Grounds {
  const Evidence& evidence;
  const Candidate& nothing;
  const Candidate& best;
  const Explanation& explanation;
  double p_best = 1.0;
  bool likelier = false;             ///< the best explanation is likelier than none
  bool certified = false;            ///< and foretells runs that it was not fitted to
  bool something = false;            ///< the residual is more than noise
  std::vector<Channel> corrections;  ///< of the revised twin
};

std::vector<Check> checks_of(const std::vector<std::string>& effects);

/// Of a diagnosis whose verdict and candidates are set.
std::string verdict_text(const Diagnosis& diagnosis, const Grounds& grounds);

}  // namespace wheel_twin::twin
