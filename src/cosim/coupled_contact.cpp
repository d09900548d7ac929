#include "cosim/coupled_contact.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "cosim/emergent.h"
#include "cosim/wheel_faces.h"
#include "rig/speeds.h"

namespace wheel_twin::cosim {
namespace {

using Eigen::Vector3d;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Cubic between two motions of the hub: position and velocity agree with both ends. `s` from 0 to 1.
wheel::HubMotion between(const wheel::HubMotion& from, const wheel::HubMotion& to, double dt, double s) {
  const double h01 = s * s * (3.0 - 2.0 * s);
  const double h10 = s * (1.0 - s) * (1.0 - s) * dt;
  const double h11 = -s * s * (1.0 - s) * dt;
  const double d01 = 6.0 * s * (1.0 - s) / dt;
  const double d10 = (1.0 - s) * (1.0 - 3.0 * s);
  const double d11 = s * (3.0 * s - 2.0);
  wheel::HubMotion hub;
  hub.position =
      from.position + h01 * (to.position - from.position) + h10 * from.velocity + h11 * to.velocity;
  hub.velocity = d01 * (to.position - from.position) + d10 * from.velocity + d11 * to.velocity;
  hub.angle = from.angle + h01 * (to.angle - from.angle) + h10 * from.rate + h11 * to.rate;
  hub.rate = d01 * (to.angle - from.angle) + d10 * from.rate + d11 * to.rate;
  hub.steering = from.steering + h01 * (to.steering - from.steering);
  return hub;
}

bool same(const rig::HubMotion& a, const rig::HubMotion& b) {
  return a.time == b.time && a.position == b.position && a.velocity == b.velocity &&
         a.wheel_angle == b.wheel_angle && a.wheel_rate == b.wheel_rate &&
         a.steering_angle == b.steering_angle;
}

}  // namespace

CoupledContact::CoupledContact(const wheel::WheelModel& model, SoilSide& soil, rig::Ports ports)
    : wheel_(model), soil_(soil), ports_(std::move(ports)) {
  radius_ = rim_radius(wheel_);
  loads_.resize(static_cast<std::size_t>(wheel_.segment_count()));
  segments_.resize(loads_.size());
  refuse_what_emerges(ports_.wheel);
  if (soil_.time_step() > wheel_.stable_step() * model.max_substeps)
    throw Error(fmt::format(
        "wheel '{}': the soil's step of {:.3g} s is beyond its stability limit of {:.3g} s in {} sub-steps",
        model.name, soil_.time_step(), wheel_.stable_step() * model.max_substeps, model.max_substeps));
}

rig::RigState CoupledContact::state_at(const rig::HubMotion& motion) const {
  rig::RigState state;
  state.time = motion.time;
  state.x = motion.position.x();
  state.carriage_speed = motion.velocity.x();
  state.wheel_angle = motion.wheel_angle;
  state.wheel_rate = motion.wheel_rate;
  state.rim_travel = rim_travel_;
  state.slip = rig::slip_ratio(motion.velocity.x(), radius_ * motion.wheel_rate);
  state.hub_displacement = -motion.position.z();
  state.slide_velocity = motion.velocity.z();
  state.steering_angle = motion.steering_angle;
  return state;
}

wheel::HubMotion CoupledContact::hub_at(const rig::HubMotion& motion) const {
  wheel::HubMotion hub;
  hub.position = motion.position + Vector3d(0.0, 0.0, radius_);
  hub.velocity = motion.velocity;
  hub.angle = motion.wheel_angle;
  hub.rate = motion.wheel_rate;
  hub.steering = motion.steering_angle;
  if (ports_.wheel.empty()) return hub;
  const auto rise_at = [&](double angle) {
    rig::RigState state = state_at(motion);
    state.wheel_angle = angle;
    return rig::hub_rise(ports_, state);
  };
  constexpr double small = 1e-4;  // rad
  hub.position.z() -= rise_at(motion.wheel_angle);
  hub.velocity.z() -= motion.wheel_rate *
                      (rise_at(motion.wheel_angle + small) - rise_at(motion.wheel_angle - small)) /
                      (2.0 * small);
  return hub;
}

void CoupledContact::read_segments() {
  for (int i = 0; i < wheel_.segment_count(); ++i) segments_[static_cast<std::size_t>(i)] = wheel_.segment(i);
}

rig::HubLoad CoupledContact::replay(const rig::HubMotion& motion) {
  const rig::HubLoad answer = to_replay_[replayed_++];
  answers_.push_back(answer);
  if (replaying()) return answer;
  if (!same(motion, resumed_.motion))
    throw Error(fmt::format("the checkpoint belongs to another run: at {:.4f} s the hub moved otherwise",
                            motion.time));
  motion_ = motion;
  hub_ = hub_at(motion);
  wheel_.place(hub_);
  wheel_.restore(resumed_.wheel);
  loads_ = resumed_.soil_loads;
  step_ = resumed_.step;
  rim_travel_ = resumed_.rim_travel;
  placed_ = true;
  read_segments();
  to_replay_.clear();
  replayed_ = 0;
  return answer;
}

rig::HubLoad CoupledContact::advance(const rig::HubMotion& motion) {
  if (replaying()) return replay(motion);
  if (!placed_) {
    placed_ = true;
    motion_ = motion;
    hub_ = hub_at(motion);
    wheel_.place(hub_);
    read_segments();
    answers_.emplace_back();
    return answers_.back();
  }
  const double dt = soil_.time_step();
  const double span = motion.time - motion_.time;
  const auto count = static_cast<int>(std::lround(span / dt));
  if (count < 1 || std::abs(span - count * dt) > 1e-6 * dt * (1.0 + count))
    throw Error(fmt::format(
        "co-simulation: from {:.6f} s to {:.6f} s is no whole number of the soil's steps of {:.6g} s",
        motion_.time, motion.time, dt));
  const wheel::HubMotion end = hub_at(motion);
  Vector3d force = Vector3d::Zero();
  Vector3d torque = Vector3d::Zero();
  for (int k = 1; k <= count; ++k) {
    const double start = seconds();
    const wheel::HubMotion before = wheel_.hub();
    const wheel::HubMotion target =
        k == count ? end : between(hub_, end, count * dt, static_cast<double>(k) / count);
    for (std::size_t i = 0; i < loads_.size(); ++i)
      wheel_.apply(static_cast<int>(i), loads_[i].force, loads_[i].torque);
    wheel_.step(dt, target);
    ++step_;
    const wheel::Wrench reaction = wheel_.reaction();
    force += reaction.force;
    torque += reaction.torque;
    const Vector3d axle(-std::sin(target.steering), std::cos(target.steering), 0.0);
    hub_work_ -= reaction.force.dot(target.position - before.position) +
                 reaction.torque.dot(axle) * (target.angle - before.angle);
    std::vector<wheel::SegmentState> last = segments_;
    read_segments();
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      soil_work_ += loads_[i].force.dot(segments_[i].position - last[i].position) +
                    0.5 * dt * loads_[i].torque.dot(segments_[i].angular_velocity + last[i].angular_velocity);
    }
    const double middle = seconds();
    loads_ = soil_.advance(step_, segments_);
    cost_.wheel += middle - start;
    cost_.soil += seconds() - middle;
    ++cost_.steps;
  }
  rim_travel_ += radius_ * std::abs(motion.wheel_angle - motion_.wheel_angle);
  motion_ = motion;
  hub_ = end;

  rig::HubLoad load;
  load.force_hub_rig = force / count;
  load.torque_hub_rig = torque / count;
  const Vector3d axle(-std::sin(motion.steering_angle), std::cos(motion.steering_angle), 0.0);
  load.drive_torque = -load.torque_hub_rig.dot(axle);
  answers_.push_back(load);
  return load;
}

CouplingEnergy CoupledContact::energy() const {
  return {hub_work_, soil_work_, wheel_.energy()};
}

CouplingState CoupledContact::state() const {
  return {step_, wheel_.save(), loads_, answers_, motion_, rim_travel_};
}

void CoupledContact::resume(CouplingState state) {
  to_replay_ = std::move(state.answers);
  state.answers.clear();
  resumed_ = std::move(state);
  replayed_ = 0;
}

}  // namespace wheel_twin::cosim
