// When a sensor samples: at multiples of its period from the start of the run, between two steps by
// interpolation.
#pragma once

#include <cstdint>

namespace wheel_twin::rig {

class SampleClock {
 public:
  explicit SampleClock(double rate) : rate_(rate) {}  ///< Hz

  /// Calls `sample(time, share)` for every sample due up to `time`, share (0 to 1] telling how far from the
  /// step before.
  template <typename Sample>
  void until(double time, const Sample& sample) {
    constexpr double slack = 1e-9;  // s, rounding of times
    while (next() <= time + slack) {
      const double due = next();
      const double share = time > last_ && due < time ? (due - last_) / (time - last_) : 1.0;
      sample(due, share < 0.0 ? 0.0 : share);
      ++taken_;
    }
    last_ = time;
  }

 private:
  double next() const { return static_cast<double>(taken_) / rate_; }
  double rate_;
  std::uint64_t taken_ = 0;
  double last_ = 0.0;
};

/// Nearest multiple of `resolution`; the value itself when it is 0.
double quantised(double value, double resolution);

}  // namespace wheel_twin::rig
