// Follows a rig by its topics while it runs: brings wrench, displacement and joints, which come at their own
// rates and times, to common ticks, leads the twin along the measured motion, and gives prediction and
// measurement of each tick. Without ROS. Stamps in nanoseconds of ROS time, everything else SI; signs as in
// run_log/run_log.h.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "nodes/channel.h"
#include "rig/ports.h"
#include "rig/rig.h"
#include "rig/step.h"

namespace wheel_twin::nodes {

struct FollowerSettings {
  double rate = 100.0;          ///< ticks a second, above 0
  double longest_wait = 0.1;    ///< a tick waits for a late channel until another is this far ahead, s
  double longest_gap = 0.25;    ///< measurements further apart are not interpolated, s
  double jump = 0.5;            ///< a stamp further back is a jump of the clock, s
  bool measured_load = true;    ///< the twin's load is the measured normal load; otherwise the declared one
  double load_filter = 0.2;     ///< time constant of a first-order filter on it, s; 0: none
  double declared_load = 42.1;  ///< N, used as long as no normal load is measured
  double least_load = 1.0;      ///< N; below it the wheel hangs and there is nothing to predict
  double steering_angle = 0.0;  ///< rad
};

/// What is led along the motion.
class FollowedTwin {
 public:
  virtual ~FollowedTwin() = default;
  /// Readings at `motion.time`; times ascend between resets.
  virtual rig::RigStep predict(const rig::MeasuredMotion& motion) = 0;
  virtual void reset() = 0;  ///< the next motion is the first of another run
};

/// Prediction and measurement at one tick. What was not measured there is absent.
struct Tick {
  Nanoseconds stamp = 0;
  Nanoseconds delay = 0;  ///< newest stamp received when the tick was computed, minus the tick's
  rig::MeasuredMotion motion;
  rig::RigStep twin;
  std::optional<rig::WrenchReading> wrench;
  std::optional<double> displacement;
  std::optional<double> effort;
};

/// What went wrong since the start.
struct FollowerEvents {
  std::size_t not_finite = 0;  ///< samples with NaN or infinity, left out
  std::size_t repeated = 0;    ///< samples not newer than the last of their channel, left out
  std::size_t time_zero = 0;   ///< samples without a stamp, left out
  std::size_t jumps = 0;       ///< clock jumped back: started again
  std::size_t gaps = 0;        ///< joints missing for longer than longest_gap: started again
  std::size_t hanging = 0;     ///< ticks without a prediction, the wheel in the air
  std::size_t incomplete = 0;  ///< ticks without wrench or without displacement
};

class Follower {
 public:
  Follower(const FollowerSettings& settings, std::unique_ptr<FollowedTwin> twin);

  void wrench(Nanoseconds stamp, const rig::WrenchReading& reading);
  void displacement(Nanoseconds stamp, double value);
  void temperature(double celsius);                                  ///< of the rig from now on
  void joints(Nanoseconds stamp, const rig::JointReading& reading);  ///< effort may be NaN: not measured

  /// Every tick that can be computed by now, in order. Throws Error when the twin's physics breaks; the
  /// follower then starts again with the next sample.
  std::vector<Tick> take();

  const FollowerEvents& events() const { return events_; }

 private:
  template <typename T>
  void add(Channel<T>& channel, Nanoseconds stamp, const T& value, bool finite);
  void restart();
  void forget_run();  ///< the next tick is the first of another run
  Nanoseconds newest() const;
  bool must_wait(Nanoseconds tick) const;
  double load_at(const std::optional<rig::WrenchReading>& wrench, Nanoseconds tick);
  /// Nothing while the wheel hangs.
  std::optional<Tick> compute(Nanoseconds tick, const rig::JointReading& joints);

  FollowerSettings settings_;
  std::unique_ptr<FollowedTwin> twin_;
  Nanoseconds period_;
  Nanoseconds wait_;
  Nanoseconds gap_;
  Nanoseconds jump_;
  Channel<rig::WrenchReading> wrench_;
  Channel<double> displacement_;
  Channel<rig::JointReading> joints_;
  std::optional<Nanoseconds> next_tick_;
  std::optional<Nanoseconds> origin_;  // of the twin's clock
  std::optional<double> temperature_;
  std::optional<double> load_;
  Nanoseconds load_stamp_ = 0;
  FollowerEvents events_;
};

}  // namespace wheel_twin::nodes
