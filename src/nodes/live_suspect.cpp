#include "nodes/live_suspect.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

constexpr double bin = 0.5;               // s
constexpr std::size_t longest = 600;      // bins that are kept
constexpr std::size_t least_bins = 12;    // of a look
constexpr std::size_t bins_between = 10;  // looks
constexpr double rest_share = 0.2;        // of the fastest speed: slower is not moving
constexpr double missing = std::numeric_limits<double>::quiet_NaN();

}  // namespace

LiveSuspect::LiveSuspect(const RigSetup& setup, const SuspectBand& band) : radius_(setup.run.radius) {
  if (setup.twin) {
    twin_ = *setup.twin;
  } else {
    twin_.wheel = setup.wheel;
    twin_.soil = setup.soil;
    twin_.rig = setup.run.rig;
  }
  twin_.table = std::make_shared<terramechanics::ContactTable>(twin_.wheel, twin_.soil);
  const rig::RunConditions& conditions = setup.run.conditions;
  declared_.load = conditions.load;
  declared_.slip = conditions.slip;
  declared_.wheel_speed = conditions.wheel_speed;
  declared_.steering_angle = conditions.steering_angle;
  const double allowed[twin::channel_count] = {band.drawbar_pull,     band.drawbar_pull, band.drawbar_pull,
                                               band.hub_displacement, band.motor_effort, band.motor_effort};
  for (std::size_t c = 0; c < twin::channel_count; ++c) {
    twin::ChannelNoise& noise = band_[c];
    noise.deviation = noise.rest = 0.3 * allowed[c];
    noise.run_offset = noise.rest_offset = 0.3 * allowed[c];
    noise.keep = 0.5;
  }
  clear();
}

void LiveSuspect::clear() {
  motion_.clear();
  measured_.clear();
  sum_ = rig::MeasuredMotion{};
  value_sum_.setZero();
  value_count_.setZero();
  ticks_ = 0;
  asked_bins_ = 0;
  told_.clear();
  stale_ = look_.valid();  // waiting for it here would hold the node
}

void LiveSuspect::add(const Tick& tick) {
  if (motion_.size() >= longest) return;
  const rig::MeasuredMotion& m = tick.motion;
  if (ticks_ > 0 && m.time >= (std::floor(sum_.time / ticks_ / bin) + 1.0) * bin) close_bin();
  if (ticks_ == 0) sum_ = rig::MeasuredMotion{}, sum_.time = sum_.temperature = 0.0, sum_.load = 0.0;
  for (double rig::MeasuredMotion::*member :
       {&rig::MeasuredMotion::time, &rig::MeasuredMotion::carriage_position,
        &rig::MeasuredMotion::carriage_velocity, &rig::MeasuredMotion::wheel_angle,
        &rig::MeasuredMotion::wheel_rate, &rig::MeasuredMotion::load, &rig::MeasuredMotion::temperature})
    sum_.*member += m.*member;
  sum_.steering_angle = m.steering_angle;
  ++ticks_;
  const auto note = [this](twin::Channel channel, double value) {
    const auto c = static_cast<Eigen::Index>(twin::index_of(channel));
    value_sum_[c] += value;
    value_count_[c] += 1.0;
  };
  if (tick.wrench) {
    note(twin::Channel::drawbar_pull, tick.wrench->force.x());
    note(twin::Channel::side_force, tick.wrench->force.y());
    note(twin::Channel::normal_load, tick.wrench->force.z());
    note(twin::Channel::pitch_torque, tick.wrench->torque.y());
  }
  if (tick.displacement) note(twin::Channel::hub_displacement, *tick.displacement);
  if (tick.effort) note(twin::Channel::motor_effort, *tick.effort);
}

void LiveSuspect::close_bin() {
  rig::MeasuredMotion mean = sum_;
  for (double rig::MeasuredMotion::*member :
       {&rig::MeasuredMotion::time, &rig::MeasuredMotion::carriage_position,
        &rig::MeasuredMotion::carriage_velocity, &rig::MeasuredMotion::wheel_angle,
        &rig::MeasuredMotion::wheel_rate, &rig::MeasuredMotion::load, &rig::MeasuredMotion::temperature})
    mean.*member /= ticks_;
  motion_.push_back(mean);
  measured_.emplace_back();
  for (Eigen::Index c = 0; c < twin::channel_rows; ++c)
    measured_.back()[c] = value_count_[c] > 0.0 ? value_sum_[c] / value_count_[c] : missing;
  value_sum_.setZero();
  value_count_.setZero();
  ticks_ = 0;
}

twin::RunGrid LiveSuspect::run_so_far() const {
  twin::RunGrid grid;
  grid.name = "live";
  grid.declared = declared_;
  grid.bin = bin;
  grid.motion = motion_;
  const auto n = static_cast<Eigen::Index>(motion_.size());
  grid.measured.resize(twin::channel_rows, n);
  double fastest = 0.0;
  const auto speed = [&](const rig::MeasuredMotion& m) {
    return std::max(std::abs(m.carriage_velocity), radius_ * std::abs(m.wheel_rate));
  };
  for (const rig::MeasuredMotion& m : motion_) fastest = std::max(fastest, speed(m));
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool changes = i > 0 && std::abs(speed(motion_[k]) - speed(motion_[k - 1])) > 0.15 * fastest;
    grid.measured.col(i) = measured_[k];
    if (changes) grid.measured.col(i).setConstant(missing);
    grid.moving.push_back(!changes && speed(motion_[k]) > rest_share * fastest);
  }
  // At rest a wheel may still hang or be let down.
  for (Eigen::Index i = 0; i < n; ++i)
    if (!grid.moving[static_cast<std::size_t>(i)]) grid.measured.col(i).setConstant(missing);
  twin::set_slip(grid, radius_);
  grid.declared.slip = twin::typical_slip(grid);
  return grid;
}

void LiveSuspect::ask() {
  if (look_.valid() || motion_.size() < std::max(least_bins, asked_bins_ + bins_between)) return;
  asked_bins_ = motion_.size();
  look_ = std::async(std::launch::async, [twin = twin_, run = run_so_far(), band = band_] {
    try {
      return twin::likeliest_effect(twin, run, band);
    } catch (const Error&) {  // the twin cannot carry what the rig does
      return std::optional<twin::LikeliestEffect>();
    }
  });
}

std::string LiveSuspect::told() {
  if (look_.valid() && look_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const std::optional<twin::LikeliestEffect> found = look_.get();
    if (std::exchange(stale_, false)) return told_;
    told_ = found ? fmt::format("likeliest effect: {}, explains {:.0f} % of the residual so far", found->name,
                                100.0 * found->explained)
                  : "no effect of the catalogue explains half of the residual so far";
  }
  return told_;
}

}  // namespace wheel_twin::nodes
