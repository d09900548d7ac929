#include "nodes/pacer.h"

#include <algorithm>

namespace wheel_twin::nodes {

void Pacer::start() {
  const std::lock_guard<std::mutex> lock(mutex_);
  start_ = Clock::now();
  time_ = 0.0;
  lag_ = 0.0;
}

bool Pacer::wait_until(double time) {
  std::unique_lock<std::mutex> lock(mutex_);
  time_ = time;
  if (factor_ > 0.0) {
    const auto due =
        start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time / factor_));
    lag_ = std::max(0.0, std::chrono::duration<double>(Clock::now() - due).count());
    wake_.wait_until(lock, due, [this] { return interrupted_; });
  }
  return !interrupted_;
}

void Pacer::interrupt() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    interrupted_ = true;
  }
  wake_.notify_all();
}

double Pacer::reached() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double wall = std::chrono::duration<double>(Clock::now() - start_).count();
  return wall > 0.0 ? time_ / wall : 0.0;
}

double Pacer::lag() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return lag_;
}

}  // namespace wheel_twin::nodes
