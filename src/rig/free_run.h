// A complete free run: rig, profile and sensors from the hoist to the stop, as a log. Can also be taken step
// by step, as a live node does.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "rig/instruments.h"
#include "rig/profile.h"
#include "rig/rig.h"

namespace wheel_twin::rig {

struct RunSettings {
  RigSettings rig;
  SensorSettings sensors;
  RunProfile profile;
  RunConditions conditions;
  double radius = 0.09;  ///< of the wheel, m
  double step = 0.001;   ///< s
  std::uint64_t seed = 1;
  double epoch = 1.7e9;  ///< ROS time of the start of the run, s
};

class FreeRun {
 public:
  /// `contact` and what `ports` point to must outlive the run. Throws Error on impossible settings.
  FreeRun(const RunSettings& settings, Contact& contact, const Ports& ports);
  ~FreeRun();
  FreeRun(FreeRun&&) noexcept;

  bool done() const;
  double time() const;  ///< s from the start of the run
  /// Expected end, s; known once the soil carries the load, before that with the deepest lowering.
  double expected_end() const;
  /// Nothing until the soil carries the load.
  const std::optional<Timeline>& timeline() const;
  const RigStep& advance();     ///< one step, taken note of by the sensors
  const RigStep& step() const;  ///< the last one
  void stop();                  ///< ramps down from here and ends, as a person presses stop
  run_log::RunLog take_log();   ///< what was logged since the last call

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Means over the steady part of a run, without noise: what a summary prints.
struct RunSummary {
  double window[2] = {0.0, 0.0};  ///< s from the start of the run
  double drawbar_pull = 0.0;      ///< N
  double side_force = 0.0;        ///< N
  double normal_load = 0.0;       ///< N
  double hub_displacement = 0.0;  ///< m
  double drive_torque = 0.0;      ///< N m
  double motor_effort = 0.0;      ///< N m
  double slip = 0.0;              ///< true, mean
};

/// Runs to the end. `observers` see every step. The means are over the second half of the steady part.
run_log::RunLog run_to_end(FreeRun& run, RunSummary& summary, const std::vector<Observer>& observers = {});

}  // namespace wheel_twin::rig
