// The flexible wheel as a multibody system (paper, Sections 6.2 and 8): rim segments joined by revolute
// joints with torsion spring-dampers, carried by spring-dampers or discretised beams on a hub that is
// prescribed or free. Rig axes: x along travel, y to the left, z up. The segments move in the wheel's plane,
// which follows the hub's position along the axle and its steering angle rigidly; forces out of the plane
// pass to the hub unchanged. Segment axes: x tangential (forward at the top of the wheel), y along the axle
// to the left, z outward. SI units.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "wheel/wheel_model.h"

namespace wheel_twin::wheel {

/// The hub as somebody moves it, rig axes.
struct HubMotion {
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< of the wheel's centre, m
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< m/s
  double angle = 0.0;                       ///< rad, grows when rolling towards +x
  double rate = 0.0;                        ///< rad/s
  double steering = 0.0;                    ///< rad, wheel turned to the left when positive; changes slowly
};

/// Directions in which the hub answers to forces instead of following a motion: along the wheel's heading,
/// up, spin.
struct HubFreedom {
  bool forward = false;
  bool up = false;
  bool spin = false;
};

struct Wrench {
  Eigen::Vector3d force{0.0, 0.0, 0.0};   ///< N
  Eigen::Vector3d torque{0.0, 0.0, 0.0};  ///< N m
};

/// A plate of a segment, in segment axes about the segment's reference point.
struct Box {
  Eigen::Vector3d centre{0.0, 0.0, 0.0};        ///< m
  Eigen::Vector3d half_extents{0.0, 0.0, 0.0};  ///< m
};

/// Where the plates of a segment are. The first box is the rim plate (its +z face is the wheel's outer face,
/// its -z face the inner one, its +x and -x faces meet the neighbours); the others are grousers.
struct SegmentShape {
  std::vector<Box> boxes;
};

/// Motion of a segment's reference point, the middle of its rim plate, in rig axes.
struct SegmentState {
  Eigen::Vector3d position{0.0, 0.0, 0.0};
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d angular_velocity{0.0, 0.0, 0.0};
};

/// A spring or beam as a line from hub to rim, rig axes, for pictures and for the load that it carries.
struct BeamState {
  int position = 0;
  int set = 0;
  std::vector<Eigen::Vector3d> points;  ///< m
  std::vector<double> bending;  ///< change of angle at each joint (beams), rad; change of length (springs), m
};

struct Energy {
  double kinetic = 0.0;     ///< J, hub included where it is free
  double elastic = 0.0;     ///< J
  double dissipated = 0.0;  ///< J, the dampers' work since place()
};

class FlexibleWheel {
 public:
  /// Throws Error with the limit for a model that makes no wheel.
  explicit FlexibleWheel(const WheelModel& model);
  ~FlexibleWheel();
  FlexibleWheel(FlexibleWheel&&) noexcept;
  FlexibleWheel& operator=(FlexibleWheel&&) noexcept;

  const WheelModel& model() const;
  int segment_count() const;
  int body_count() const;                        ///< segments and the bodies of beams
  const SegmentShape& shape(int segment) const;  ///< does not change
  double rim_mass() const;                       ///< kg, everything but the hub
  /// The longest sub-step that is stable, s: 90 % of the linear limit of the undeformed wheel, dampers
  /// included.
  double stable_step() const;

  /// Puts the undeformed wheel on the hub, moving with it as a rigid wheel. Clears forces and step counter.
  void place(const HubMotion& hub);
  void set_freedom(const HubFreedom& freedom);
  /// Gravity on segments, beams and a free hub, m/s^2 downward (along -z). 0 until set.
  void set_gravity(double gravity);
  /// Force and torque on the hub from outside (load, drive), rig axes; act where the hub is free. Kept until
  /// changed.
  void set_hub_load(const Wrench& load);

  /// Adds a force on a segment at its reference point and a torque, rig axes; both act during the next step
  /// only.
  void apply(int segment, const Eigen::Vector3d& force, const Eigen::Vector3d& torque);
  /// Adds a force at a point given in rig axes.
  void apply_at(int segment, const Eigen::Vector3d& force, const Eigen::Vector3d& point);

  /// Advances by `dt`. Where the hub is not free it moves to `hub_at_end`. Throws Error naming step and
  /// segment for a force that is not finite, and naming the limit for a step beyond stable_step() times the
  /// sub-steps.
  void step(double dt, const HubMotion& hub_at_end);

  SegmentState segment(int index) const;  ///< now
  HubMotion hub() const;                  ///< now
  /// What the rim exerts on the hub about its centre, rig axes, mean over the last step.
  Wrench reaction() const;
  std::vector<BeamState> beams() const;
  /// Change of the angle between segment `index` and the next one, rad, positive when the rim bends more than
  /// undeformed; 0 of a rigid wheel.
  double rim_bending(int index) const;
  Energy energy() const;
  /// Angular momentum about the axle's direction through the rig's origin, kg m^2/s, hub included.
  double angular_momentum() const;
  double largest_joint_gap() const;  ///< after the last step, m
  std::int64_t steps() const;        ///< since place()

  /// Brings the wheel to rest about the hub under the forces that `forces` applies before every step: dynamic
  /// relaxation with a mass-proportional damper of `rate` (1/s), until the rim's speed about the hub falls
  /// below `tolerance` (m/s) or `limit` steps are done (then throws Error).
  template <class Forces>
  void relax(double dt, double rate, double tolerance, std::int64_t limit, Forces&& forces) {
    set_relaxation(rate);
    const HubMotion target = hub();
    for (std::int64_t i = 0;; ++i) {
      forces(*this);
      step(dt, target);
      if (i > 50 && relative_speed() < tolerance) break;
      if (i >= limit) fail_relaxation(tolerance);
    }
    set_relaxation(0.0);
  }
  void set_relaxation(
      double rate);  ///< damper against motion about the hub's (a free hub's: about the rig), 1/s
  double relative_speed() const;  ///< largest speed of a body about the hub's rigid motion, m/s

  /// The whole state; restoring it into a wheel of the same model continues with identical bits.
  std::vector<double> save() const;
  void restore(const std::vector<double>& state);  ///< throws Error when the size does not fit the model

 private:
  [[noreturn]] void fail_relaxation(double tolerance) const;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::wheel
