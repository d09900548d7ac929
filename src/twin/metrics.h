// Errors of a twin over the runs of an experiment, and the yardsticks beside them: the scatter of repeated
// runs, which no twin can beat, and the best constant, which every twin should. SI units.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "twin/run_comparison.h"

namespace wheel_twin::twin {

struct ErrorSummary {
  double rmse = 0.0;  ///< root mean square of the runs' errors
  double mean = 0.0;  ///< mean of twin - measured over the runs' means
  std::size_t runs = 0;
};

struct RepeatScatter {
  double std = 0.0;            ///< pooled standard deviation of the means of repeated runs
  std::size_t runs = 0;        ///< that have a repetition
  std::size_t conditions = 0;  ///< among which they spread
};

using RunFilter = std::function<bool(const logs::Run&)>;

/// Steering angle below 1 degree.
bool is_straight(const logs::Run& run);
/// Slip above 0.05.
bool is_driving(const logs::Run& run);

/// None where no run that passes the filter has the channel.
std::optional<ErrorSummary> error_of(const std::vector<RunComparison>& runs, Channel channel,
                                     const RunFilter& filter);

/// Error of the best constant for the means of the runs that pass the filter. None with fewer than two.
std::optional<double> error_of_constant(const std::vector<RunComparison>& runs, Channel channel,
                                        const RunFilter& filter);

/// Runs count as repeated when slip, steering angle and declared load agree to 0.02, 1 degree and 2 % and
/// both or neither are reference runs (between those, the rig was changed). None without any.
std::optional<RepeatScatter> repeat_scatter(const std::vector<RunComparison>& runs, Channel channel,
                                            const RunFilter& filter);

}  // namespace wheel_twin::twin
