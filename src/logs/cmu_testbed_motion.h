// The testbed's kinematics in SI units, rig axes and on one clock. What its clocks and speeds are like was
// found in the data (doc/importing_logs.md): the controller's clock runs 0.14 % slow but evenly, the
// computer's is right on average but stamps late when busy; speeds are computed over a cycle that is taken
// 0.38 ms too long, so that both of them read about 2.8 % low against the position, their ratio (slip) being
// right; rim speed is the wheel's rate times 62.5 mm.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "logs/cmu_testbed_tables.h"

namespace wheel_twin::logs::cmu {

/// Radius by which the controller turns wheel rate into rim speed, m.
inline constexpr double controller_radius = 0.0625;

/// Hours that a computer of the rig's place (US Eastern time) is behind UTC at this local time, s since 1970.
int hours_behind_utc(double local_time);

struct Motion {
  double epoch = 0.0;                     ///< UTC of the first row, s
  std::vector<double> time;               ///< s from the first row, computer clock without its jitter
  std::vector<double> carriage_position;  ///< m, 0 at the first row
  std::vector<double> carriage_velocity;  ///< m/s, corrected
  std::vector<double> wheel_angle;        ///< rad, 0 at the first row
  std::vector<double> wheel_rate;         ///< rad/s, corrected
  std::vector<double> z;                  ///< m, up, as logged

  double speed_factor =
      1.0;  ///< travelled distance over the integral of the logged speed; both speeds times this
  double clock_skew = 0.0;  ///< controller clock behind computer clock, fraction
  double late_stamp = 0.0;  ///< worst lateness of a computer stamp, s
  double rate = 0.0;        ///< rows a second
  std::size_t frozen = 0;   ///< rows at the end that repeat the last reading: left out
  std::size_t spikes = 0;   ///< single wrong readings of the rim speed, replaced by their neighbours'
};

/// `wheel_locked`: the wheel was commanded to stand (its reading then saw-tooths about 0 by the encoder's
/// quantum and is taken as 0 from the time that the carriage has its speed and the command is given,
/// `locked_from`).
Motion to_motion(const Kinematics& kinematics, int hours_behind, bool wheel_locked,
                 double locked_from = 20.0);

}  // namespace wheel_twin::logs::cmu
