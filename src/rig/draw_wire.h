// Draw-wire displacement sensor with incremental encoder: range, linearity, noise, resolution. It hangs above
// the slide, which draws its wire out as the hub sinks. m, positive down, zeroed at first touch.
#pragma once

#include <cstdint>

#include "base/random.h"
#include "rig/sample_clock.h"
#include "rig/sensor_settings.h"
#include "run_log/run_log.h"

namespace wheel_twin::rig {

class DrawWire {
 public:
  DrawWire(const DrawWireSettings& settings, std::uint64_t seed);
  /// As FtSensor::observe. `delay` is added to the stamps, s.
  void observe(double time, double displacement, double delay, run_log::ScalarSeries& series);

 private:
  double reading(double displacement);
  double linearity_error(double wire) const;

  DrawWireSettings settings_;
  Random random_;
  SampleClock clock_;
  double phase_;  // of the linearity error, rad: every sensor has its own
  bool started_ = false;
  double last_ = 0.0;
};

}  // namespace wheel_twin::rig
