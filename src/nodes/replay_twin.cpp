#include "nodes/replay_twin.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rig/semi_empirical_contact.h"
#include "rig/speeds.h"

namespace wheel_twin::nodes {
namespace {

constexpr double rolling_speed = 1e-3;  // m/s; the corrections are of a wheel that moves

void correct(const twin::Correction& correction, double amount, rig::Readings& readings) {
  switch (correction.channel) {
    case twin::Channel::drawbar_pull:
      readings.wrench.force.x() += amount;
      return;
    case twin::Channel::side_force:
      readings.wrench.force.y() += amount;
      return;
    case twin::Channel::normal_load:
      readings.wrench.force.z() += amount;
      return;
    case twin::Channel::hub_displacement:
      readings.displacement += amount;
      return;
    case twin::Channel::pitch_torque:
      readings.wrench.torque.y() += amount;
      return;
    case twin::Channel::motor_effort:
      readings.joints.wheel_effort += amount;
  }
}

}  // namespace

ReplayTwin::ReplayTwin(RigSetup setup) : setup_(std::move(setup)) {
  if (setup_.twin) acting_ = twin::acting_effects(*setup_.twin);
  reset();
}

void ReplayTwin::reset() {
  replay_.reset();
  rig::SemiEmpiricalOptions options;
  if (setup_.twin) options.start_up = setup_.twin->start_up;
  contact_ = std::make_unique<rig::SemiEmpiricalContact>(setup_.wheel, setup_.soil, acting_.ports, options);
  const rig::RunSettings& run = setup_.run;
  replay_ = std::make_unique<rig::Replay>(run.rig, run.conditions, run.radius, *contact_, acting_.ports,
                                          rig::ReplayOptions{});
}

rig::RigStep ReplayTwin::predict(const rig::MeasuredMotion& motion) {
  rig::RigStep step = replay_->update(motion);
  const double rim = setup_.run.radius * motion.wheel_rate;
  if (setup_.twin && std::max(std::abs(motion.carriage_velocity), std::abs(rim)) > rolling_speed) {
    const double slip = rig::slip_ratio(motion.carriage_velocity, rim);
    for (const twin::Correction& c : setup_.twin->corrections)
      correct(c, c.at(slip, setup_.run.conditions.load), step.readings);
  }
  return step;
}

}  // namespace wheel_twin::nodes
