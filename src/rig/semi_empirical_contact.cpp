#include "rig/semi_empirical_contact.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "rig/speeds.h"

namespace wheel_twin::rig {
namespace {

using terramechanics::ContactState;
using terramechanics::Operation;
using terramechanics::SoilChange;

/// The layers of the ports at one state of the rig.
class PortFactor : public terramechanics::DepthFactor {
 public:
  PortFactor(const std::vector<const SoilPort*>& ports, const RigState& state)
      : ports_(ports), state_(state) {}
  double operator()(double depth) const override {
    double factor = 1.0;
    for (const SoilPort* port : ports_) factor *= port->layer_factor(state_, depth);
    return factor;
  }

 private:
  const std::vector<const SoilPort*>& ports_;
  const RigState& state_;
};

}  // namespace

/// What a motion means to the contact.
struct SemiEmpiricalContact::Moment {
  bool moving = false;
  double slip = 0.0;
  double rim_speed = 0.0;
};

SemiEmpiricalContact::SemiEmpiricalContact(const terramechanics::Wheel& wheel,
                                           const terramechanics::Soil& soil, Ports ports,
                                           SemiEmpiricalOptions options)
    : model_(wheel, soil, options.table), ports_(std::move(ports)), options_(std::move(options)) {
  if (!(options_.damping >= 0.0))
    throw Error(fmt::format("semi-empirical contact: damping {:g} s/m is negative", options_.damping));
}

SemiEmpiricalContact::Moment SemiEmpiricalContact::moment(const HubMotion& motion) {
  const double v = motion.velocity.x();
  Moment m;
  m.rim_speed = motion.wheel_rate * model_.wheel().radius;
  const double faster = std::max(std::abs(v), std::abs(m.rim_speed));
  m.moving = faster >= rest_speed;
  if (!started_ || motion.time > now_.time) {
    before_ = now_;
    if (!started_) before_.time = motion.time, before_.x = motion.position.x();
    started_ = true;
  } else if (motion.time < now_.time) {
    throw Error(fmt::format("semi-empirical contact: time goes back from {:.6f} to {:.6f} s", now_.time,
                            motion.time));
  }
  now_ = before_;
  const double dt = motion.time - before_.time;
  now_.time = motion.time;
  now_.x = motion.position.x();
  if (now_.touched) {
    now_.travel += dt * faster;
    now_.rim_travel += dt * std::abs(m.rim_speed);
  }
  if (m.moving) {
    now_.direction = (std::abs(v) >= rest_speed ? v : m.rim_speed) < 0.0 ? -1.0 : 1.0;
    // Rolling against the travel is treated as locked: shear is full there as well.
    m.slip = slip_ratio(now_.direction * v, std::max(0.0, now_.direction * m.rim_speed));
    now_.operation.slip = m.slip;
  }
  now_.operation.steering_angle = now_.direction * motion.steering_angle;
  return m;
}

RigState SemiEmpiricalContact::rig_state(const HubMotion& motion, const Moment& m) const {
  RigState s;
  s.time = motion.time;
  s.x = motion.position.x();
  s.carriage_speed = motion.velocity.x();
  s.wheel_angle = motion.wheel_angle;
  s.wheel_rate = motion.wheel_rate;
  s.rim_travel = now_.rim_travel;
  s.slip = m.slip;
  s.hub_displacement = -motion.position.z();
  s.slide_velocity = motion.velocity.z();
  s.steering_angle = motion.steering_angle;
  return s;
}

double SemiEmpiricalContact::stiffness(const ContactState& state, bool rolling, const SoilChange& change) {
  const double h = state.hub_displacement, slip = now_.operation.slip;
  if (rolling != stiffness_.rolling || !(std::abs(h - stiffness_.hub_displacement) <= 0.01 * h) ||
      std::abs(slip - stiffness_.slip) > 0.02) {
    const double value = rolling ? model_.vertical_stiffness(state, now_.operation, change)
                                 : model_.vertical_stiffness_at_rest(state, change);
    stiffness_ = {value, h, slip, rolling};
  }
  return stiffness_.value;
}

HubLoad SemiEmpiricalContact::advance(const HubMotion& motion) {
  const Moment m = moment(motion);
  const RigState rig = rig_state(motion, m);

  double slope = 0.0;
  SoilChange change;
  const PortFactor factor(ports_.soil, rig);
  for (const SoilPort* port : ports_.soil) {
    slope += port->surface_slope(rig);
    change.added_cohesion += port->added_cohesion(rig);
    change.sinkage_factor *= port->sinkage_factor(rig);
    change.stiffness_factor *= port->stiffness_factor(rig);
    if (port->layered()) change.depth_factor = &factor;
  }
  now_.surface = before_.surface + (now_.x - before_.x) * std::tan(slope);
  const double cos_a = std::cos(slope), sin_a = std::sin(slope);

  const double h = (now_.surface - motion.position.z() + hub_rise(ports_, rig)) * cos_a;
  HubLoad load;
  if (h <= 0.0) {
    state_ = ContactState{};
    state_.hub_displacement = h;
    return load;
  }
  now_.touched = true;

  const double guess = state_.deflection > 0.0 ? state_.deflection * h / state_.hub_displacement : -1.0;
  const Operation& operation = now_.operation;
  ContactState rolling, rest;
  double rolled = 0.0;  // share of the rolling state
  if (now_.travel > 0.0) {
    rolling = model_.at_hub_displacement(h, operation, change, guess);
    const double half_contact =
        0.5 * model_.wheel().radius * (std::sin(rolling.entry_angle) - std::sin(rolling.exit_angle));
    rolled = -std::expm1(-now_.travel / std::max(options_.start_up * half_contact, 1e-9));
    if (rolled > 1.0 - 1e-9) rolled = 1.0;
  }
  if (rolled < 1.0) rest = model_.at_rest_at_hub_displacement(h, change, guess);
  state_ = rolled > 0.0 ? rolling : rest;
  const double normal = rolled * rolling.normal_load + (1.0 - rolled) * rest.normal_load;
  state_.normal_load = normal;

  const double indentation = -motion.velocity.z() + motion.velocity.x() * std::tan(slope);
  const double loss = std::clamp(1.0 + options_.damping * indentation, 0.0, 2.0);
  const double shear = m.moving ? rolled * loss : 0.0;
  const double direction = now_.direction;
  double along = direction * shear * rolling.drawbar_pull;
  double across = shear * rolling.side_force;
  if (m.moving && std::abs(m.rim_speed) >= rest_speed) {
    double resistance = 0.0;
    for (const WheelPort* port : ports_.wheel) resistance += port->rolling_resistance(rig);
    along -= direction * rolled * resistance * std::cos(motion.steering_angle);
    across -= direction * rolled * resistance * std::sin(motion.steering_angle);
  }
  const double up = loss * normal;
  load.force_hub_rig = {along * cos_a - up * sin_a, across, along * sin_a + up * cos_a};
  const double torque_x = shear * rolling.torque_x, torque_z = direction * shear * rolling.torque_z;
  load.torque_hub_rig = {torque_x * cos_a - torque_z * sin_a, direction * shear * rolling.torque_y,
                         torque_x * sin_a + torque_z * cos_a};
  load.drive_torque = direction * shear * rolling.drive_torque;
  load.vertical_stiffness = rolled > 0.5 ? stiffness(rolling, true, change) : stiffness(rest, false, change);
  for (const SoilPort* port : ports_.soil) load.force_hub_rig += port->added_force(rig, up);
  return load;
}

}  // namespace wheel_twin::rig
