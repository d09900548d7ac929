// Six-axis force/torque sensor: analogue first-order low-pass, white noise, bias, drift, resolution, and a
// range that the weight hanging on it uses up. Sensor axes are rig axes; tared; N and N m.
#pragma once

#include <cstdint>

#include "base/random.h"
#include "rig/sample_clock.h"
#include "rig/sensor_settings.h"
#include "rig/step.h"
#include "run_log/run_log.h"

namespace wheel_twin::rig {

class FtSensor {
 public:
  FtSensor(const FtSettings& settings, std::uint64_t seed);
  /// Takes note of the signal at `time`, s from the start of the run, ascending; adds the samples due to
  /// `series`.
  void observe(double time, const WrenchReading& signal, run_log::WrenchSeries& series);

 private:
  Vector6 reading(double time, const Vector6& filtered);

  FtSettings settings_;
  Vector6 tare_ = Vector6::Zero();  // what the tare added
  Random random_;
  SampleClock clock_;
  bool started_ = false;
  double last_time_ = 0.0;
  Vector6 last_ = Vector6::Zero();      // signal at the last step
  Vector6 filtered_ = Vector6::Zero();  // after the low-pass
};

}  // namespace wheel_twin::rig
