#include "rig/ft_sensor.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::rig {

FtSensor::FtSensor(const FtSettings& settings, std::uint64_t seed)
    : settings_(settings), random_(seed, 1), clock_(settings.rate) {
  tare_[2] = settings_.tool_weight;
}

void FtSensor::observe(double time, const WrenchReading& signal, run_log::WrenchSeries& series) {
  Vector6 now;
  now << signal.force, signal.torque;
  const Vector6 before = filtered_;
  if (!started_ || settings_.low_pass <= 0.0) {
    filtered_ = now;
  } else {
    // The signal rises linearly over the step; the filter's response to it is exact.
    const double lag = 1.0 / (2.0 * 3.14159265358979323846 * settings_.low_pass);
    const double dt = time - last_time_;
    const double decay = std::exp(-dt / lag);
    const Vector6 slope = (now - last_) / dt;
    filtered_ = now - lag * slope + decay * (before - last_ + lag * slope);
  }
  const Vector6 start = started_ ? before : filtered_;
  clock_.until(time, [&](double due, double share) {
    const Vector6 value = reading(due, start + share * (filtered_ - start));
    series.time.push_back(due);
    series.force.push_back(value.head<3>());
    series.torque.push_back(value.tail<3>());
  });
  started_ = true;
  last_time_ = time;
  last_ = now;
}

Vector6 FtSensor::reading(double time, const Vector6& filtered) {
  Vector6 value;
  for (int i = 0; i < 6; ++i) {
    const double noise = settings_.noise[i] > 0.0 ? settings_.noise[i] * random_.normal() : 0.0;
    const double signal = filtered[i] + settings_.bias[i] + settings_.drift[i] * time + noise;
    const double range = settings_.range[i];
    value[i] = std::clamp(quantised(signal, settings_.resolution[i]), tare_[i] - range, tare_[i] + range);
  }
  return value;
}

}  // namespace wheel_twin::rig
