// A short memory of one measured channel by header stamp: takes samples as they arrive, refuses repeated and
// older ones, notices a clock that jumped back, and interpolates. Stamps in nanoseconds of ROS time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>

#include "rig/ports.h"
#include "rig/step.h"

namespace wheel_twin::nodes {

using Nanoseconds = std::int64_t;

enum class Arrival {
  accepted,
  repeated,    ///< not newer than what is there: left out
  jumped_back  ///< older than the newest by more than a late sample can be: left out, the clock has jumped
};

/// Linear between a (share 0) and b (share 1).
double blend(double a, double b, double share);
rig::WrenchReading blend(const rig::WrenchReading& a, const rig::WrenchReading& b, double share);
rig::JointReading blend(const rig::JointReading& a, const rig::JointReading& b, double share);

template <typename T>
class Channel {
 public:
  Arrival add(Nanoseconds stamp, const T& value, Nanoseconds jump) {
    if (!samples_.empty() && stamp <= samples_.back().stamp)
      return stamp < samples_.back().stamp - jump ? Arrival::jumped_back : Arrival::repeated;
    samples_.push_back({stamp, value});
    return Arrival::accepted;
  }

  void clear() { samples_.clear(); }
  bool empty() const { return samples_.empty(); }
  Nanoseconds oldest() const { return samples_.front().stamp; }
  Nanoseconds newest() const { return samples_.back().stamp; }

  /// Interpolated between the two samples about `stamp`; nothing when they are further apart than `widest` or
  /// when there are none on both sides.
  std::optional<T> at(Nanoseconds stamp, Nanoseconds widest) const {
    const auto after = not_before(stamp);
    if (after == samples_.end()) return std::nullopt;
    if (after->stamp == stamp) return after->value;
    if (after == samples_.begin()) return std::nullopt;
    const auto before = std::prev(after);
    if (after->stamp - before->stamp > widest) return std::nullopt;
    const double share =
        static_cast<double>(stamp - before->stamp) / static_cast<double>(after->stamp - before->stamp);
    return blend(before->value, after->value, share);
  }

  /// Stamp of the first sample at or after `stamp`.
  std::optional<Nanoseconds> next(Nanoseconds stamp) const {
    const auto after = not_before(stamp);
    if (after == samples_.end()) return std::nullopt;
    return after->stamp;
  }

  /// Forgets what is older than `stamp`, except for the last sample before it.
  void forget(Nanoseconds stamp) {
    while (samples_.size() > 1 && samples_[1].stamp <= stamp) samples_.pop_front();
  }

 private:
  struct Sample {
    Nanoseconds stamp;
    T value;
  };
  typename std::deque<Sample>::const_iterator not_before(Nanoseconds stamp) const {
    return std::lower_bound(samples_.begin(), samples_.end(), stamp,
                            [](const Sample& sample, Nanoseconds wanted) { return sample.stamp < wanted; });
  }
  std::deque<Sample> samples_;
};

}  // namespace wheel_twin::nodes
