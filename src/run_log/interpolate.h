// Linear interpolation in a series of a run's log.
#pragma once

#include <algorithm>
#include <cstddef>

#include "run_log/run_log.h"

namespace wheel_twin::run_log {

/// The value at `time`; before the first and after the last sample theirs. Times ascend; not for an empty
/// series.
inline double value_at(const ScalarSeries& series, double time) {
  const auto after = std::lower_bound(series.time.begin(), series.time.end(), time);
  if (after == series.time.begin()) return series.value.front();
  if (after == series.time.end()) return series.value.back();
  const auto i = static_cast<std::size_t>(after - series.time.begin());
  const double share = (time - series.time[i - 1]) / (series.time[i] - series.time[i - 1]);
  return series.value[i - 1] + share * (series.value[i] - series.value[i - 1]);
}

}  // namespace wheel_twin::run_log
