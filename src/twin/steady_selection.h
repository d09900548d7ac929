// Forward selection among the effects of the catalogue on runs known by means: what to add is what foretells
// groups left out best, as long as each addition is certified there and lowers the error by a fair share.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "twin/steady_fit.h"

namespace wheel_twin::twin {

/// One explanation that was looked at closely.
struct Trial {
  SteadyFit fit;
  LeftOut left_out;
  double score =
      0.0;  ///< log of how well groups left out are foretold, cooled by what no explanation reaches
};

struct Selection {
  Trial nothing;
  Trial chosen;               ///< `nothing` again where no effect was accepted
  std::vector<Trial> trials;  ///< all that were looked at closely, best score first
  double p = 1.0;  ///< corrected for the number of effects: worst certificate of the accepted effects, or
                   ///< that of the best one refused
};

struct SelectionOptions {
  std::size_t most_effects = 3;
  std::size_t close_looks = 6;  ///< candidates of a step that are left out group by group
  double false_alarm_rate = 0.05;
  int threads = 1;
  std::function<void(double share)> progress = nullptr;  ///< of the work of one step
};

/// `names`: the effects to choose from. Throws Error when the twin without effects cannot carry the runs.
Selection select_effects(const SteadyEvidence& evidence, const SteadyRuns& runs,
                         const std::vector<std::string>& names, const SelectionOptions& options);

/// Effects that window means can tell, and why the others cannot.
struct Tellable {
  std::vector<std::string> names;
  std::vector<std::string> left_aside;  ///< "name: reason"
};
Tellable tellable_effects(const SteadyEvidence& evidence, const SteadyRuns& runs);

}  // namespace wheel_twin::twin
