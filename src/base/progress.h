// A progress line with the time left on standard error, drawn only when a person watches (a terminal).
#pragma once

#include <chrono>
#include <string>

namespace wheel_twin {

class Progress {
 public:
  Progress(std::string what, double total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(double done);  ///< cheap enough to call at every step: draws at most five times a second

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  double total_;
  bool visible_;
  Clock::time_point start_;
  Clock::time_point drawn_;
};

}  // namespace wheel_twin
