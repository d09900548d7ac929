// The rig led by a measured motion: what every channel should have read. Fast (quasi-static, coarse steps)
// for a diagnosis that calls it thousands of times, and incremental for a twin that follows a rig while it
// runs. No noise: readings after the sensor ports, before noise, filter, range and resolution.
#pragma once

#include <optional>
#include <vector>

#include "rig/rig.h"
#include "run_log/run_log.h"

namespace wheel_twin::rig {

struct ReplayOptions {
  Slide slide = Slide::quasi_static;
  double step = 0.02;        ///< longest step, s; dynamic: 0.001 at most
  double rest_speed = 2e-4;  ///< slower carriages and rims are taken to stand still (encoder noise), m/s
  /// Hub displacement at the first sample, m; none: in equilibrium on the soil.
  std::optional<double> initial_displacement;
};

/// Follows sample by sample; the step in between is divided as the options say, the motion interpolated.
class Replay {
 public:
  /// As for Rig. `conditions` gives load, steering angle and the like; the samples bring the motion.
  Replay(const RigSettings& settings, const RunConditions& conditions, double radius, Contact& contact,
         Ports ports, const ReplayOptions& options);

  /// The readings at `motion.time`. Throws Error when time does not increase.
  const RigStep& update(const MeasuredMotion& motion);
  /// After a jump of the clock, backward or forward: `time` (new clock) is where the last sample stood in the
  /// old one; the next sample must be later. The state stays.
  void rebase(double time);
  const RigStep& step() const { return rig_.step(); }
  double draw_wire_delay() const { return rig_.draw_wire_delay(); }

 private:
  MeasuredMotion rest_filtered(MeasuredMotion motion) const;

  Rig rig_;
  double radius_;
  ReplayOptions options_;
  std::optional<MeasuredMotion> last_;  // in the clock of the rig
  double clock_offset_ = 0.0;           // rig time minus sample time, s
  bool rebase_pending_ = false;
  double rebase_time_ = 0.0;
};

using MotionSeries = std::vector<MeasuredMotion>;

/// The motion in a log, one entry a joint sample, times from the log's. Velocities are smoothed by a centred
/// average over `window` seconds (0: as logged). `conditions` gives load and steering angle; temperature
/// comes from the log where it has one. Throws Error when the log has no joint states.
MotionSeries motion_of_log(const run_log::RunLog& log, const RunConditions& conditions, double window = 0.1);

/// Stamps at which each channel is wanted, each ascending, s.
struct SampleTimes {
  std::vector<double> wrench;
  std::vector<double> displacement;
  std::vector<double> effort;
};

struct Prediction {
  std::vector<WrenchReading> wrench;
  std::vector<double> displacement;
  std::vector<double> effort;
};

/// Every channel at the asked stamps, interpolated between steps, held before the first and after the last;
/// the delay of the draw wire is honoured.
Prediction predict(const RigSettings& settings, const RunConditions& conditions, double radius,
                   Contact& contact, const Ports& ports, const MotionSeries& motion, const SampleTimes& times,
                   const ReplayOptions& options);

}  // namespace wheel_twin::rig
