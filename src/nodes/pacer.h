// Keeps simulated time at a chosen multiple of the wall clock, measures what is really reached, and can be
// interrupted.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace wheel_twin::nodes {

class Pacer {
 public:
  /// `factor`: simulated seconds a wall second; 0: as fast as possible.
  explicit Pacer(double factor) : factor_(factor) {}

  void start();  ///< simulated time 0 is now
  /// Waits until the wall clock has come to simulated `time`, s. False when interrupted.
  bool wait_until(double time);
  void interrupt();  ///< ends the present wait and every later one, from any thread

  double reached() const;  ///< simulated over wall time since start
  double lag() const;      ///< wall seconds by which the last wait came too late, 0 when in time

 private:
  using Clock = std::chrono::steady_clock;
  double factor_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool interrupted_ = false;
  Clock::time_point start_ = Clock::now();
  double time_ = 0.0;
  double lag_ = 0.0;
};

}  // namespace wheel_twin::nodes
