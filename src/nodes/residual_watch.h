// Says whether the residual of a channel is more than its limit: root mean square over a sliding window of
// ticks.
#pragma once

#include <cstddef>
#include <deque>

namespace wheel_twin::nodes {

class ResidualWatch {
 public:
  /// `length` ticks, at least 1; `limit` in the unit of the channel, above 0.
  ResidualWatch(std::size_t length, double limit);

  void add(double residual);  ///< finite
  void clear();
  double rms() const;     ///< 0 when nothing has been added
  bool exceeded() const;  ///< the window is full and its RMS above the limit
  double limit() const { return limit_; }

 private:
  std::size_t length_;
  double limit_;
  std::deque<double> squares_;
  double sum_ = 0.0;
};

}  // namespace wheel_twin::nodes
