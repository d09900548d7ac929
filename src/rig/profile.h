// The course of a free run: lowered gently to first touch and until the soil carries the load, dwell, ramp,
// steady, stop.
#pragma once

#include "base/yaml.h"
#include "rig/speeds.h"

namespace wheel_twin::rig {

struct RunProfile {
  double clearance = 0.002;      ///< hub above first touch at the start, m
  double lowering_speed = 0.01;  ///< the hoist pays out, m/s; it never pushes
  double dwell = 1.0;            ///< at rest after the load has been handed over, s
  double ramp = 0.1;             ///< of both speeds, s
  double travel = 0.7;           ///< of the carriage in the steady part, m; 0: by time alone
  double longest_steady = 62.0;  ///< s
  double rest = 1.0;             ///< after the ramp down, s
};

RunProfile read_profile(const yaml::Map& map);

/// When things happen in a run, s from its start. The soil carries the load from `handed_over` on.
struct Timeline {
  double handed_over = 0.0;
  double ramp_up = 0.0;
  double steady = 0.0;
  double ramp_down = 0.0;
  double rest = 0.0;
  double end = 0.0;
};

/// The course of a run whose load was handed over to the soil at `handed_over`.
Timeline timeline(const RunProfile& profile, const Speeds& speeds, double handed_over);

/// Share of the full speeds commanded at `time`: 0, ramps, 1.
double speed_share(const Timeline& timeline, double time);

}  // namespace wheel_twin::rig
