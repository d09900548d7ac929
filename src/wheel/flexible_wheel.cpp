#include "wheel/flexible_wheel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "wheel/wheel_builder.h"

namespace wheel_twin::wheel {

using Eigen::Quaterniond;
using Eigen::Vector3d;

struct FlexibleWheel::Impl {
  explicit Impl(const WheelModel& wheel_model)
      : model((check(wheel_model), wheel_model)), built(build(model)), system(built.parts) {
    rigid = model.suspension == Suspension::rigid;
    stable = rigid ? 1.0e9 : stability_limit();
  }

  /// 90 % of the longest step that no mode outgrows. One step takes a mode with w = omega h and a = zeta w
  /// (dampers seen at both half-steps) through a matrix of determinant (1 - a)^2 and trace 1 + (1 - a)^2 -
  /// w^2 (2 - a)/2.
  double stability_limit() {
    const double highest = system.highest_frequency();
    if (!(highest > 0.0)) return 1.0e9;
    const auto stable_at = [&](double h) {
      for (int k = 1; k <= 100; ++k) {
        const double w = 0.01 * k * highest * h;
        const double a = 0.5 * system.damping_time() * 0.01 * k * highest * w;
        if (a >= 2.0 || w * w * (2.0 - a) >= 4.0 * (1.0 + (1.0 - a) * (1.0 - a))) return false;
      }
      return true;
    };
    double low = 0.0;
    double high = 2.5 / highest;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      (stable_at(middle) ? low : high) = middle;
    }
    return 0.9 * low;
  }

  Vector3d heading() const { return {std::cos(motion.steering), std::sin(motion.steering), 0.0}; }
  Vector3d axle() const { return {-std::sin(motion.steering), std::cos(motion.steering), 0.0}; }
  PlanarPose in_plane(const HubMotion& hub) const {
    const Vector3d forward{std::cos(hub.steering), std::sin(hub.steering), 0.0};
    return {{hub.position.dot(forward), hub.position.z()},
            hub.angle,
            {hub.velocity.dot(forward), hub.velocity.z()},
            hub.rate};
  }
  Vector3d to_rig(Vec2 v) const { return v.x * heading() + Vector3d(0.0, 0.0, v.z); }

  /// The reference point of a segment in plane axes, and the motion of the body that carries it.
  PlanarPose reference_pose(int i) const {
    PlanarPose pose = system.pose(rigid ? system.hub() : i);
    const Vec2 arm = rigid ? system.arm(system.hub(), built.segments[i].reference_on_hub)
                           : system.arm(i, built.segments[i].reference);
    pose.position = pose.position + arm;
    pose.velocity = pose.velocity + pose.rate * perp(arm);
    if (rigid) pose.angle += built.segments[i].angle;
    return pose;
  }

  void add(int i, const Vector3d& force, const Vector3d& torque) {
    if (!force.allFinite() || !torque.allFinite()) {
      if (broken_segment < 0) broken_segment = i;
      return;
    }
    const Vec2 f{force.dot(heading()), force.z()};
    const PlanarPose at = reference_pose(i);
    PlanarForce& external = system.external(rigid ? system.hub() : i);
    const Vec2 arm = at.position - system.pose(rigid ? system.hub() : i).position;
    const double turning = torque.dot(axle()) + dot(perp(arm), f);
    external.force = external.force + f;
    external.torque += turning;
    applied.force = applied.force + f;
    applied.torque += turning;
    // Out of the plane the wheel is rigid: straight to the hub.
    const Vector3d side = force.dot(axle()) * axle();
    const Vec2 from_hub = at.position - system.pose(system.hub()).position;
    across.force += side;
    across.torque += to_rig(from_hub).cross(side) + torque - torque.dot(axle()) * axle();
  }

  void advance(double dt, const HubMotion& end);

  WheelModel model;
  BuiltWheel built;
  PlanarSystem system;
  bool rigid = false;
  double stable = 0.0;
  HubMotion motion;  // the prescription's last value; position along the axle and steering hold always
  HubFreedom freedom;
  Wrench hub_load;
  Wrench across;        // out-of-plane part of the applied forces of the coming step
  PlanarForce applied;  // in-plane part, about the centre of the body that takes it
  Wrench reaction;
  double gravity = 0.0;
  std::int64_t steps = 0;
  int broken_segment = -1;
};

void FlexibleWheel::Impl::advance(double dt, const HubMotion& end) {
  if (end.steering != motion.steering) {
    const PlanarPose old_plane = in_plane(motion);
    HubMotion turned = motion;
    turned.steering = end.steering;
    const PlanarPose new_plane = in_plane(turned);
    system.shift(new_plane.position - old_plane.position, new_plane.velocity - old_plane.velocity);
    motion.steering = end.steering;
  }
  const int hub = system.hub();
  system.external(hub).force =
      system.external(hub).force + Vec2{hub_load.force.dot(heading()), hub_load.force.z()};
  system.external(hub).torque += hub_load.torque.dot(axle());
  const PlanarPose first = system.pose(hub);
  const PlanarPose last = in_plane(end);
  const int n = std::max(1, static_cast<int>(std::ceil(dt / stable * (1.0 - 1.0e-12))));
  const double h = dt / n;
  system.take_hub_impulse();
  for (int k = 1; k <= n; ++k) {
    // Cubic between the two ends, so that position and velocity agree at every sub-step.
    const double s = static_cast<double>(k) / n;
    const double a = s * s * (3.0 - 2.0 * s), b = s * (1.0 - s) * (1.0 - s) * dt, c = -s * s * (1.0 - s) * dt;
    const double da = 6.0 * s * (1.0 - s) / dt, db = (1.0 - s) * (1.0 - 3.0 * s), dc = s * (3.0 * s - 2.0);
    const auto position = [&](double p0, double p1, double v0, double v1) {
      return p0 + a * (p1 - p0) + b * v0 + c * v1;
    };
    const auto velocity = [&](double p0, double p1, double v0, double v1) {
      return da * (p1 - p0) + db * v0 + dc * v1;
    };
    PlanarPose target = last;
    if (k < n) {
      target.position = {position(first.position.x, last.position.x, first.velocity.x, last.velocity.x),
                         position(first.position.z, last.position.z, first.velocity.z, last.velocity.z)};
      target.velocity = {velocity(first.position.x, last.position.x, first.velocity.x, last.velocity.x),
                         velocity(first.position.z, last.position.z, first.velocity.z, last.velocity.z)};
      target.angle = position(first.angle, last.angle, first.rate, last.rate);
      target.rate = velocity(first.angle, last.angle, first.rate, last.rate);
    }
    system.step(h, target);
  }
  PlanarForce on_hub = system.take_hub_impulse();
  if (rigid) {
    const PlanarPose now = system.pose(hub);
    on_hub.force = dt * applied.force - built.rim_mass * (now.velocity - first.velocity);
    on_hub.force.z -= dt * built.rim_mass * gravity;
    on_hub.torque = dt * applied.torque - built.rim_inertia * (now.rate - first.rate);
  }
  reaction.force = to_rig((1.0 / dt) * on_hub.force) + across.force;
  reaction.torque = (on_hub.torque / dt) * axle() + across.torque;
  const double steering = motion.steering;
  motion = end;
  motion.steering = steering;
  system.clear_external();
  across = {};
  applied = {};
  ++steps;
}

FlexibleWheel::FlexibleWheel(const WheelModel& model) : impl_(std::make_unique<Impl>(model)) {
  place({});
}
FlexibleWheel::~FlexibleWheel() = default;
FlexibleWheel::FlexibleWheel(FlexibleWheel&&) noexcept = default;
FlexibleWheel& FlexibleWheel::operator=(FlexibleWheel&&) noexcept = default;

const WheelModel& FlexibleWheel::model() const {
  return impl_->model;
}
int FlexibleWheel::segment_count() const {
  return impl_->model.segments;
}
int FlexibleWheel::body_count() const {
  return impl_->rigid ? segment_count() : impl_->system.bodies();
}
const SegmentShape& FlexibleWheel::shape(int segment) const {
  return impl_->built.segments[segment].shape;
}
double FlexibleWheel::rim_mass() const {
  return impl_->built.rim_mass;
}
double FlexibleWheel::stable_step() const {
  return impl_->stable;
}
std::int64_t FlexibleWheel::steps() const {
  return impl_->steps;
}
Wrench FlexibleWheel::reaction() const {
  return impl_->reaction;
}
double FlexibleWheel::angular_momentum() const {
  return impl_->system.angular_momentum();
}
double FlexibleWheel::relative_speed() const {
  return impl_->system.relative_speed();
}
double FlexibleWheel::largest_joint_gap() const {
  return impl_->system.largest_gap();
}
void FlexibleWheel::set_relaxation(double rate) {
  impl_->system.set_relaxation(rate);
}
void FlexibleWheel::set_hub_load(const Wrench& load) {
  impl_->hub_load = load;
}

void FlexibleWheel::place(const HubMotion& hub) {
  impl_->motion = hub;
  impl_->system.place(impl_->in_plane(hub));
  impl_->across = {};
  impl_->applied = {};
  impl_->reaction = {};
  impl_->steps = 0;
  impl_->broken_segment = -1;
}

void FlexibleWheel::set_freedom(const HubFreedom& freedom) {
  impl_->freedom = freedom;
  impl_->system.set_hub_free({freedom.forward, freedom.up, freedom.spin});
}

void FlexibleWheel::set_gravity(double gravity) {
  impl_->gravity = gravity;
  impl_->system.set_gravity(gravity);
}

void FlexibleWheel::apply(int segment, const Vector3d& force, const Vector3d& torque) {
  impl_->add(segment, force, torque);
}

void FlexibleWheel::apply_at(int segment, const Vector3d& force, const Vector3d& point) {
  const PlanarPose at = impl_->reference_pose(segment);
  const Vector3d reference =
      impl_->to_rig(at.position) + impl_->motion.position.dot(impl_->axle()) * impl_->axle();
  impl_->add(segment, force, (point - reference).cross(force));
}

void FlexibleWheel::step(double dt, const HubMotion& hub_at_end) {
  Impl& impl = *impl_;
  if (impl.broken_segment >= 0) {
    throw Error(fmt::format("wheel '{}', step {}: the force on segment {} is not finite", impl.model.name,
                            impl.steps, impl.broken_segment));
  }
  if (!(dt > 0.0) || dt > impl.stable * impl.model.max_substeps) {
    throw Error(
        fmt::format("wheel '{}': a time step of {:.4g} s in {} sub-steps is beyond the stability limit of "
                    "{:.4g} s",
                    impl.model.name, dt, impl.model.max_substeps, impl.stable * impl.model.max_substeps));
  }
  try {
    impl.advance(dt, hub_at_end);
  } catch (const Error& error) {
    throw Error(fmt::format("wheel '{}', step {}: {}", impl.model.name, impl.steps, error.what()));
  }
}

SegmentState FlexibleWheel::segment(int index) const {
  const PlanarPose pose = impl_->reference_pose(index);
  const Vector3d axle = impl_->axle();
  SegmentState state;
  state.position = impl_->to_rig(pose.position) + impl_->motion.position.dot(axle) * axle;
  state.velocity = impl_->to_rig(pose.velocity) + impl_->motion.velocity.dot(axle) * axle;
  const double half_turn = 0.5 * pose.angle;
  const double half_steering = 0.5 * impl_->motion.steering;
  const double c = std::cos(half_turn), s = std::sin(half_turn);
  const double d = std::cos(half_steering), t = std::sin(half_steering);
  state.orientation = Quaterniond(d * c, -t * s, d * s, t * c);  // about z, then about the axle
  state.angular_velocity = pose.rate * axle;
  return state;
}

HubMotion FlexibleWheel::hub() const {
  const PlanarPose pose = impl_->system.pose(impl_->system.hub());
  const Vector3d axle = impl_->axle();
  HubMotion hub = impl_->motion;
  hub.position = impl_->to_rig(pose.position) + impl_->motion.position.dot(axle) * axle;
  hub.velocity = impl_->to_rig(pose.velocity) + impl_->motion.velocity.dot(axle) * axle;
  hub.angle = pose.angle;
  hub.rate = pose.rate;
  return hub;
}

std::vector<BeamState> FlexibleWheel::beams() const {
  const Impl& impl = *impl_;
  const PlanarSystem& system = impl.system;
  const bool chain = impl.model.suspension == Suspension::beams;
  const Vector3d axle = impl.axle();
  const Vec2 centre = system.pose(system.hub()).position;
  const int sets = chain ? impl.model.beams.sets : impl.model.springs.sets;
  std::vector<BeamState> states;
  for (const BuiltBeam& beam : impl.built.beams) {
    BeamState state;
    state.position = beam.position;
    state.set = beam.set;
    const double side = ((beam.set + 0.5) / sets - 0.5) * impl.model.width;
    const auto point = [&](Vec2 p) {
      state.points.push_back(impl.to_rig(p) + (impl.motion.position.dot(axle) + side) * axle);
    };
    point(centre +
          system.arm(system.hub(), impl.model.hub_radius * Vec2{std::sin(beam.angle), std::cos(beam.angle)}));
    if (chain) {
      const int n = impl.model.beams.bodies;
      for (int k = 0; k < n; ++k) {
        const int body = beam.first_body + k;
        const PlanarJoint& next = impl.built.parts.joints[beam.first_joint + k + 1];
        point(system.pose(body).position + system.arm(body, k + 1 < n ? -1.0 * next.at_a : next.at_b));
      }
      for (int k = 0; k <= n; ++k) state.bending.push_back(system.joint_angle(beam.first_joint + k));
    } else {
      const PlanarSpring& spring = impl.built.parts.springs[beam.spring];
      point(system.pose(spring.body).position + system.arm(spring.body, spring.at_body));
      state.bending.push_back(system.spring_stretch(beam.spring));
    }
    states.push_back(std::move(state));
  }
  return states;
}

double FlexibleWheel::rim_bending(int index) const {
  if (impl_->rigid) return 0.0;
  // The rim's joints are the last ones.
  const auto first = impl_->built.parts.joints.size() - impl_->model.segments;
  return impl_->system.joint_angle(static_cast<int>(first) + index);
}

Energy FlexibleWheel::energy() const {
  return {impl_->system.kinetic_energy(), impl_->system.elastic_energy(), impl_->system.dissipated()};
}

std::vector<double> FlexibleWheel::save() const {
  const Impl& impl = *impl_;
  const HubMotion& m = impl.motion;
  std::vector<double> out{static_cast<double>(impl.steps), m.angle, m.rate, m.steering};
  for (const Vector3d& v : {m.position, m.velocity, impl.hub_load.force, impl.hub_load.torque,
                            impl.reaction.force, impl.reaction.torque}) {
    out.insert(out.end(), {v.x(), v.y(), v.z()});
  }
  impl.system.save(out);
  return out;
}

void FlexibleWheel::restore(const std::vector<double>& state) {
  Impl& impl = *impl_;
  const std::size_t expected = 22 + impl.system.state_size();
  if (state.size() != expected) {
    throw Error(fmt::format("wheel '{}': a state of {} numbers does not fit, {} are needed", impl.model.name,
                            state.size(), expected));
  }
  const double* in = state.data();
  impl.steps = static_cast<std::int64_t>(*in++);
  HubMotion& m = impl.motion;
  m.angle = *in++;
  m.rate = *in++;
  m.steering = *in++;
  for (Vector3d* v : {&m.position, &m.velocity, &impl.hub_load.force, &impl.hub_load.torque,
                      &impl.reaction.force, &impl.reaction.torque}) {
    *v = {in[0], in[1], in[2]};
    in += 3;
  }
  impl.system.restore(in);
  impl.gravity = impl.system.gravity();
  impl.across = {};
  impl.applied = {};
  impl.broken_segment = -1;
}

void FlexibleWheel::fail_relaxation(double tolerance) const {
  throw Error(fmt::format("wheel '{}', step {}: no rest, speed {:.3g} m/s is still above {:.3g}",
                          model().name, steps(), relative_speed(), tolerance));
}

}  // namespace wheel_twin::wheel
