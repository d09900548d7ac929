// The sensors of a rig together: each samples the steps of a run at its own rate with its own random stream
// and writes its series of the log.
#pragma once

#include <cstdint>
#include <memory>

#include "rig/sensor_settings.h"
#include "rig/step.h"
#include "run_log/run_log.h"

namespace wheel_twin::rig {

class Instruments {
 public:
  /// The same seed gives the same bits. `epoch` is the ROS time of the start of the run, s, above 0.
  Instruments(const SensorSettings& settings, std::uint64_t seed, double epoch);
  ~Instruments();
  Instruments(Instruments&&) noexcept;

  /// Takes note of a step; times ascend. `draw_wire_delay` is added to the draw wire's stamps.
  void observe(const RigStep& step, double draw_wire_delay);
  /// What has been logged since the last call (or since the start), moved out.
  run_log::RunLog take();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::rig
