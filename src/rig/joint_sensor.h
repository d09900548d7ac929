// Motor encoders and motor current of carriage and wheel, and the thermometer: noise and resolution.
#pragma once

#include <cstdint>

#include "base/random.h"
#include "rig/sample_clock.h"
#include "rig/sensor_settings.h"
#include "rig/step.h"
#include "run_log/run_log.h"

namespace wheel_twin::rig {

class JointSensor {
 public:
  JointSensor(const JointSettings& settings, std::uint64_t seed);
  /// As FtSensor::observe.
  void observe(double time, const JointReading& signal, run_log::JointSeries& series);

 private:
  JointSettings settings_;
  Random random_;
  SampleClock clock_;
  bool started_ = false;
  JointReading last_;
};

class Thermometer {
 public:
  Thermometer(const TemperatureSettings& settings, std::uint64_t seed);
  void observe(double time, double celsius, run_log::ScalarSeries& series);

 private:
  TemperatureSettings settings_;
  Random random_;
  SampleClock clock_;
};

}  // namespace wheel_twin::rig
