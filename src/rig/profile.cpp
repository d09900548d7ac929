#include "rig/profile.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::rig {

RunProfile read_profile(const yaml::Map& map) {
  RunProfile profile;
  profile.clearance = map.number_or("clearance", profile.clearance, {0.0, 0.2});
  profile.lowering_speed = map.number_or("lowering_speed", profile.lowering_speed, {1e-4, 0.2});
  profile.dwell = map.number_or("dwell", profile.dwell, {0.0, 3600.0});
  profile.ramp = map.number_or("ramp", profile.ramp, {0.0, 60.0});
  profile.travel = map.number_or("travel", profile.travel, {0.0, 1000.0});
  profile.longest_steady = map.number_or("longest_steady", profile.longest_steady, {1e-3, 86400.0});
  profile.rest = map.number_or("rest", profile.rest, {0.0, 3600.0});
  map.finish();
  return profile;
}

Timeline timeline(const RunProfile& profile, const Speeds& speeds, double handed_over) {
  double steady = profile.longest_steady;
  const double speed = std::abs(speeds.carriage);
  if (profile.travel > 0.0 && speed > rest_speed) steady = std::min(steady, profile.travel / speed);
  Timeline line;
  line.handed_over = handed_over;
  line.ramp_up = line.handed_over + profile.dwell;
  line.steady = line.ramp_up + profile.ramp;
  line.ramp_down = line.steady + steady;
  line.rest = line.ramp_down + profile.ramp;
  line.end = line.rest + profile.rest;
  return line;
}

double speed_share(const Timeline& line, double time) {
  if (time <= line.ramp_up || time >= line.rest) return 0.0;
  if (time < line.steady) return (time - line.ramp_up) / (line.steady - line.ramp_up);
  if (time <= line.ramp_down) return 1.0;
  return (line.rest - time) / (line.rest - line.ramp_down);
}

}  // namespace wheel_twin::rig
