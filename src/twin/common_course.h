// A course over time that runs of different slip have in common after an explanation was taken off: something
// that happens by the clock, in every run, and that the explanation does not have.
#pragma once

#include <optional>
#include <vector>

#include "twin/run_grid.h"
#include "twin/simulate.h"

namespace wheel_twin::twin {

struct CommonCourse {
  Channel channel = Channel::drawbar_pull;
  double deviation = 0.0;  ///< root mean square over time, of what the runs have in common, SI
  double share = 0.0;      ///< that over the deviation of what each run has of its own
  double p = 1.0;       ///< that runs put together at random times agree as well; corrected for the channels
  double time = 0.0;    ///< of its steepest change, s from the start of a run
  double change = 0.0;  ///< there, over two seconds, SI
};

/// The channel in which the runs have most in common, levels of the runs apart, the first seconds of motion
/// left out; nothing with less than three runs. `residuals` of each run.
std::optional<CommonCourse> common_course(const std::vector<const RunGrid*>& runs,
                                          const std::vector<Residual>& residuals);

}  // namespace wheel_twin::twin
