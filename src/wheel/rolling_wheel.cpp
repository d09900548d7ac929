#include "wheel/rolling_wheel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "base/error.h"

namespace wheel_twin::wheel {

using Eigen::Vector3d;

namespace {

constexpr double kRelaxation = 150.0;  // 1/s, near the critical damping of a loaded wheel
constexpr std::int64_t kLeastSteps = 50, kMostSteps = 2000000;  // until rest
constexpr double kStandingStiffness = 1.0e6;   // N/m a corner: overlaps are small beside deflections
constexpr double kStandingTolerance = 1.0e-7;  // m/s

bool level(const Ground& ground) {
  return ground.floor && ground.boxes.empty() && ground.spheres.empty() && ground.rocks.empty();
}

}  // namespace

RollingWheel::RollingWheel(const WheelModel& model, const RollingSettings& settings)
    : settings_(settings), wheel_(model) {
  start_.angle = settings.start_angle;
  wheel_.place(start_);
  const Ground& ground = settings.ground;
  if (level(ground)) {
    touch_ = *ground.floor - RigidFloor::lowest_corner(wheel_);
    floor_ = std::make_unique<RigidFloor>(
        wheel_, FloorProperties{*ground.floor, ground.contact.stiffness, ground.contact.damping,
                                ground.contact.friction});
  } else {
    touch_ = RigidGround::touching_height(wheel_, ground);
    ground_ = std::make_unique<RigidGround>(wheel_, ground);
  }
  start_.position.z() = touch_;
  wheel_.place(start_);
  wheel_.set_freedom({false, true, false});
  set_load(settings.load);
  time_step_ = std::min(settings.time_step, wheel_.stable_step());
}

void RollingWheel::set_load(double load) {
  wheel_.set_hub_load({{0.0, 0.0, -load}, Vector3d::Zero()});
}

Vector3d RollingWheel::press() {
  return floor_ ? floor_->press(wheel_, time_step_) : ground_->press(wheel_, time_step_);
}

void RollingWheel::settle(double tolerance, const std::function<bool()>& stop) {
  wheel_.set_freedom({false, true, false});
  wheel_.set_relaxation(kRelaxation);
  const HubMotion target = wheel_.hub();
  std::int64_t steps = 0;
  do {
    if (++steps > kMostSteps)
      throw Error(fmt::format("wheel '{}': no rest under the load: speed {:.3g} m/s is still above {:.3g}",
                              wheel_.model().name, wheel_.relative_speed(), tolerance));
    force_ = press();
    wheel_.step(time_step_, target);
  } while ((steps < kLeastSteps || wheel_.relative_speed() > tolerance) && !(stop && stop()));
  wheel_.set_relaxation(0.0);
  start_ = wheel_.hub();
  start_.velocity.setZero();
  start_.rate = 0.0;
  time_ = 0.0;
}

void RollingWheel::step() {
  if (time_ == 0.0) wheel_.set_freedom({false, true, true});
  force_ = press();
  time_ += time_step_;
  const double v = settings_.speed, ramp = settings_.ramp;
  const double s = ramp > 0.0 ? std::min(1.0, time_ / ramp) : 1.0;
  if (settings_.coasts && s >= 1.0) wheel_.set_freedom({true, true, true});
  HubMotion hub = start_;
  hub.velocity.x() = v * s * s * (3.0 - 2.0 * s);
  hub.position.x() += v * (s < 1.0 ? ramp * (s * s * s - 0.5 * s * s * s * s) : 0.5 * ramp + (time_ - ramp));
  wheel_.step(time_step_, hub);
}

double RollingWheel::deflection() const {
  const double overlap =
      floor_ ? std::max(0.0, *settings_.ground.floor - RigidFloor::lowest_corner(wheel_)) : 0.0;
  return touch_ - wheel_.hub().position.z() - overlap;
}

std::vector<LoadPoint> load_deflection(const WheelModel& model, const std::vector<double>& loads,
                                       double angle, const std::function<void()>& done) {
  std::vector<LoadPoint> curve;
  if (model.suspension == Suspension::rigid) {
    for (const double load : loads) curve.push_back({load, 0.0});
    return curve;
  }
  RollingSettings settings;
  settings.start_angle = angle;
  settings.time_step = 1.0e-5;
  settings.ground.contact.stiffness = kStandingStiffness;
  RollingWheel standing(model, settings);
  for (const double load : loads) {
    standing.set_load(load);
    standing.settle(kStandingTolerance);
    curve.push_back({load, standing.deflection()});
    if (done) done();
  }
  return curve;
}

}  // namespace wheel_twin::wheel
