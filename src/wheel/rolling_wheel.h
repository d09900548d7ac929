// A wheel that stands or rolls on hard ground: its hub carries a load, is drawn along travel at a speed, and
// is free to rise and to turn, as a towed wheel. Gives the hub's load-deflection curve, rolling height and
// resistance. Rig axes, SI units.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "wheel/flexible_wheel.h"
#include "wheel/ground.h"
#include "wheel/rigid_floor.h"
#include "wheel/rigid_ground.h"

namespace wheel_twin::wheel {

struct RollingSettings {
  double load = 42.1;         ///< N down on the hub
  double speed = 0.1;         ///< m/s of the hub along x
  double ramp = 0.25;         ///< s to come to speed, without a jump of the acceleration
  double start_angle = 0.0;   ///< of the wheel, rad
  bool coasts = false;        ///< left alone once it has come to speed
  double time_step = 2.0e-5;  ///< s at most; the wheel's own limit may ask for less
  Ground ground;
};

class RollingWheel {
 public:
  /// Puts the wheel just above the ground at x = 0.
  RollingWheel(const WheelModel& model, const RollingSettings& settings);

  /// Lets the wheel come to rest on the ground under the load, hub held against rolling: motion slower than
  /// `tolerance`, m/s. Gives up when `stop` says so. Throws Error when it does not come to rest.
  void settle(double tolerance = 1.0e-5, const std::function<bool()>& stop = {});
  void set_load(double load);  ///< N; settle() again
  void step();                 ///< rolls on by one time step

  const FlexibleWheel& wheel() const { return wheel_; }
  double time() const { return time_; }                    ///< s since rolling began
  double time_step() const { return time_step_; }          ///< s
  Eigen::Vector3d ground_force() const { return force_; }  ///< on the wheel in the last step, N
  /// How much lower the hub is than that of a wheel that just touches, less the ground's own give under it
  /// (on a floor), m.
  double deflection() const;

 private:
  Eigen::Vector3d press();

  RollingSettings settings_;
  FlexibleWheel wheel_;
  std::unique_ptr<RigidFloor> floor_;    // a level floor alone
  std::unique_ptr<RigidGround> ground_;  // anything else
  double touch_ = 0.0;                   // hub height, m
  double time_step_ = 0.0;
  double time_ = 0.0;
  HubMotion start_;
  Eigen::Vector3d force_{0.0, 0.0, 0.0};
};

struct LoadPoint {
  double load = 0.0;        ///< N
  double deflection = 0.0;  ///< m
};
/// Hub deflection of a standing wheel under each of `loads` (N, ascending) on a level floor; `angle` is the
/// wheel's, rad; `done` is called after each. A rigid wheel does not deflect.
std::vector<LoadPoint> load_deflection(const WheelModel& model, const std::vector<double>& loads,
                                       double angle = 0.0, const std::function<void()>& done = {});

}  // namespace wheel_twin::wheel
