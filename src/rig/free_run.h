// A complete free run: rig, profile and sensors from the hoist to the stop, as a log. Can also be taken step
// by step, as a live node does.
#pragma once

#include <cstdint>
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

  bool done() const { return time_ >= timeline_.end; }
  double time() const { return time_; }  ///< s from the start of the run
  const Timeline& timeline() const { return timeline_; }
  const RigStep& advance();  ///< one step
  void stop();               ///< ramps down from here and ends, as a person presses stop
  run_log::RunLog take_log() { return instruments_.take(); }  ///< what was logged since the last call

 private:
  RunSettings settings_;
  Speeds speeds_;
  Timeline timeline_;
  Rig rig_;
  Instruments instruments_;
  double time_ = 0.0;
  std::uint64_t steps_ = 0;
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
