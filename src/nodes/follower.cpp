#include "nodes/follower.h"

#include <cmath>
#include <utility>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

Nanoseconds nanoseconds(double seconds) {
  return std::llround(seconds * 1e9);
}

bool finite(const rig::JointReading& joints) {
  return std::isfinite(joints.carriage_position) && std::isfinite(joints.carriage_velocity) &&
         std::isfinite(joints.wheel_angle) && std::isfinite(joints.wheel_rate);
}

}  // namespace

Follower::Follower(const FollowerSettings& settings, std::unique_ptr<FollowedTwin> twin)
    : settings_(settings),
      twin_(std::move(twin)),
      period_(settings.rate > 0.0 ? nanoseconds(1.0 / settings.rate) : 0),
      wait_(nanoseconds(settings.longest_wait)),
      gap_(nanoseconds(settings.longest_gap)),
      jump_(nanoseconds(settings.jump)) {
  if (period_ <= 0) throw Error("live twin: rate must be above 0 Hz");
  if (wait_ < 0 || gap_ <= 0 || jump_ <= 0)
    throw Error("live twin: wait, gap and jump must be positive times");
}

void Follower::restart() {
  wrench_.clear();
  displacement_.clear();
  joints_.clear();
  next_tick_.reset();
  forget_run();
}

void Follower::forget_run() {
  if (origin_) twin_->reset();
  origin_.reset();
  load_.reset();
}

template <typename T>
void Follower::add(Channel<T>& channel, Nanoseconds stamp, const T& value, bool finite) {
  if (stamp <= 0) {
    ++events_.time_zero;
    return;
  }
  if (!finite) {
    ++events_.not_finite;
    return;
  }
  const Arrival arrival = channel.add(stamp, value, jump_);
  if (arrival == Arrival::repeated) ++events_.repeated;
  if (arrival == Arrival::jumped_back) {
    ++events_.jumps;
    restart();
    channel.add(stamp, value, jump_);
  }
  // A channel whose partners are silent must not grow for ever.
  const Nanoseconds needed = next_tick_.value_or(newest()) - gap_;
  wrench_.forget(std::min(needed, newest() - gap_));
  displacement_.forget(std::min(needed, newest() - gap_));
}

void Follower::wrench(Nanoseconds stamp, const rig::WrenchReading& reading) {
  add(wrench_, stamp, reading, reading.force.allFinite() && reading.torque.allFinite());
}

void Follower::displacement(Nanoseconds stamp, double value) {
  add(displacement_, stamp, value, std::isfinite(value));
}

void Follower::temperature(double celsius) {
  if (std::isfinite(celsius))
    temperature_ = celsius;
  else
    ++events_.not_finite;
}

void Follower::joints(Nanoseconds stamp, const rig::JointReading& reading) {
  add(joints_, stamp, reading, finite(reading));
}

Nanoseconds Follower::newest() const {
  Nanoseconds newest = 0;
  if (!wrench_.empty()) newest = std::max(newest, wrench_.newest());
  if (!displacement_.empty()) newest = std::max(newest, displacement_.newest());
  if (!joints_.empty()) newest = std::max(newest, joints_.newest());
  return newest;
}

bool Follower::must_wait(Nanoseconds tick) const {
  if (newest() - tick >= wait_) return false;
  return wrench_.empty() || wrench_.newest() < tick || displacement_.empty() || displacement_.newest() < tick;
}

double Follower::load_at(const std::optional<rig::WrenchReading>& wrench, Nanoseconds tick) {
  if (!settings_.measured_load) return settings_.declared_load;
  if (!wrench) return load_.value_or(settings_.declared_load);
  const double measured = std::max(0.0, wrench->force.z());
  if (!load_ || settings_.load_filter <= 0.0) {
    load_ = measured;
  } else {
    const double elapsed = 1e-9 * static_cast<double>(tick - load_stamp_);
    *load_ += (measured - *load_) * (1.0 - std::exp(-elapsed / settings_.load_filter));
  }
  load_stamp_ = tick;
  return *load_;
}

std::optional<Tick> Follower::compute(Nanoseconds tick, const rig::JointReading& joints) {
  Tick result;
  result.stamp = tick;
  result.delay = newest() - tick;
  result.wrench = wrench_.at(tick, gap_);
  result.motion.load = load_at(result.wrench, tick);
  if (result.motion.load < settings_.least_load) {
    ++events_.hanging;
    if (origin_) twin_->reset();
    origin_.reset();
    return std::nullopt;
  }
  if (!origin_) origin_ = tick;
  result.displacement = displacement_.at(tick, gap_);
  if (std::isfinite(joints.wheel_effort)) result.effort = joints.wheel_effort;
  if (!result.wrench || !result.displacement) ++events_.incomplete;
  result.motion.time = 1e-9 * static_cast<double>(tick - *origin_);
  result.motion.carriage_position = joints.carriage_position;
  result.motion.carriage_velocity = joints.carriage_velocity;
  result.motion.wheel_angle = joints.wheel_angle;
  result.motion.wheel_rate = joints.wheel_rate;
  result.motion.steering_angle = settings_.steering_angle;
  if (temperature_) result.motion.temperature = *temperature_;
  result.twin = twin_->predict(result.motion);
  return result;
}

std::vector<Tick> Follower::take() {
  std::vector<Tick> ticks;
  while (!joints_.empty()) {
    if (!next_tick_) next_tick_ = (joints_.oldest() + period_ - 1) / period_ * period_;
    const auto following = joints_.next(*next_tick_);
    if (!following || must_wait(*next_tick_)) break;
    const auto joints = joints_.at(*next_tick_, gap_);
    if (!joints) {  // the joints were silent: another start after the gap
      if (origin_) ++events_.gaps;
      next_tick_ = (*following + period_ - 1) / period_ * period_;
      forget_run();
      continue;
    }
    try {
      if (auto tick = compute(*next_tick_, *joints)) ticks.push_back(std::move(*tick));
    } catch (const Error&) {
      restart();
      throw;
    }
    *next_tick_ += period_;
    joints_.forget(*next_tick_);
    wrench_.forget(*next_tick_);
    displacement_.forget(*next_tick_);
  }
  return ticks;
}

}  // namespace wheel_twin::nodes
