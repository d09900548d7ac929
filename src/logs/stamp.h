// Times of a log: seconds since an epoch in memory, whole nanoseconds in a bag. The epoch of a log is a whole
// number of microseconds (a double holds today's times to 0.24 microseconds), so that reading and writing
// again gives the same stamps.
#pragma once

#include <cmath>
#include <cstdint>

namespace wheel_twin::logs {

/// Nanoseconds of ROS time. `epoch` and `time` in s; `epoch` is rounded to a microsecond.
inline std::int64_t to_nanoseconds(double epoch, double time) {
  const double whole = std::floor(epoch);
  const auto microseconds = static_cast<std::int64_t>(whole) * 1000000 + std::llround((epoch - whole) * 1e6);
  return microseconds * 1000 + std::llround(time * 1e9);
}

/// Seconds from `epoch` (a whole number of microseconds, in nanoseconds) to `stamp` (nanoseconds).
inline double seconds_since(std::int64_t epoch, std::int64_t stamp) {
  return static_cast<double>(stamp - epoch) / 1e9;
}

}  // namespace wheel_twin::logs
