#include "rig/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace wheel_twin::rig {
namespace {

MeasuredMotion between(const MeasuredMotion& a, const MeasuredMotion& b, double share) {
  const auto at = [&](double MeasuredMotion::*member) { return a.*member + share * (b.*member - a.*member); };
  MeasuredMotion motion;
  motion.time = at(&MeasuredMotion::time);
  motion.carriage_position = at(&MeasuredMotion::carriage_position);
  motion.carriage_velocity = at(&MeasuredMotion::carriage_velocity);
  motion.wheel_angle = at(&MeasuredMotion::wheel_angle);
  motion.wheel_rate = at(&MeasuredMotion::wheel_rate);
  motion.load = at(&MeasuredMotion::load);
  motion.steering_angle = at(&MeasuredMotion::steering_angle);
  motion.temperature = at(&MeasuredMotion::temperature);
  return motion;
}

/// Interpolates in series with ascending times, asked at ascending times.
class Cursor {
 public:
  explicit Cursor(const std::vector<double>& times) : times_(times) {}

  /// Index i and share so that the value at `time` is v[i] + share (v[i + 1] - v[i]); held at both ends.
  std::pair<std::size_t, double> at(double time) {
    while (index_ + 2 < times_.size() && times_[index_ + 1] <= time) ++index_;
    if (times_.size() < 2) return {0, 0.0};
    const double span = times_[index_ + 1] - times_[index_];
    return {index_, span > 0.0 ? std::clamp((time - times_[index_]) / span, 0.0, 1.0) : 1.0};
  }

 private:
  const std::vector<double>& times_;
  std::size_t index_ = 0;
};

template <typename T>
T interpolated(const std::vector<T>& values, std::pair<std::size_t, double> place) {
  if (place.second <= 0.0) return values[place.first];
  return T(values[place.first] + place.second * (values[place.first + 1] - values[place.first]));
}

/// Centred average over `window`, shorter at the ends.
std::vector<double> smoothed(const std::vector<double>& times, const std::vector<double>& values,
                             double window) {
  std::vector<double> result(values.size());
  std::size_t first = 0;
  std::size_t last = 0;  // one past
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double half = std::min({0.5 * window, times[i] - times.front(), times.back() - times[i]}) + 1e-9;
    while (last < values.size() && times[last] <= times[i] + half) sum += values[last++];
    while (times[first] < times[i] - half) sum -= values[first++];
    while (last > i + 1 && times[last - 1] > times[i] + half) sum -= values[--last];
    result[i] = sum / static_cast<double>(last - first);
  }
  return result;
}

}  // namespace

Replay::Replay(const RigSettings& settings, const RunConditions& conditions, double radius, Contact& contact,
               Ports ports, const ReplayOptions& options)
    : rig_(settings, conditions, radius, contact, std::move(ports)), radius_(radius), options_(options) {
  if (!(options_.step > 0.0)) throw Error(fmt::format("replay: a step of {} s", options_.step));
}

MeasuredMotion Replay::rest_filtered(MeasuredMotion motion) const {
  if (std::abs(motion.carriage_velocity) < options_.rest_speed) motion.carriage_velocity = 0.0;
  if (std::abs(radius_ * motion.wheel_rate) < options_.rest_speed) motion.wheel_rate = 0.0;
  return motion;
}

const RigStep& Replay::update(const MeasuredMotion& measured) {
  MeasuredMotion motion = rest_filtered(measured);
  if (rebase_pending_) {
    clock_offset_ = last_->time - rebase_time_;
    rebase_pending_ = false;
  }
  motion.time += clock_offset_;
  if (!last_) {
    last_ = motion;
    return rig_.start(motion, options_.initial_displacement);
  }
  const MeasuredMotion from = *last_;
  const double span = motion.time - from.time;
  if (!(span > 0.0))
    throw Error(
        fmt::format("replay: the motion at {:.6f} s is not later than the one before", measured.time));
  const int parts = std::max(1, static_cast<int>(std::ceil(span / options_.step - 1e-9)));
  for (int i = 1; i < parts; ++i)
    rig_.follow(between(from, motion, static_cast<double>(i) / static_cast<double>(parts)), options_.slide);
  last_ = motion;
  return rig_.follow(motion, options_.slide);
}

void Replay::rebase(double time) {
  if (!last_) return;
  rebase_pending_ = true;
  rebase_time_ = time;
}

MotionSeries motion_of_log(const run_log::RunLog& log, const RunConditions& conditions, double window) {
  const run_log::JointSeries& joints = log.joints;
  if (joints.time.empty()) throw Error("the log has no joint states: there is no motion to follow");
  const std::vector<double> velocity = smoothed(joints.time, joints.carriage_velocity, window);
  const std::vector<double> rate = smoothed(joints.time, joints.wheel_rate, window);
  Cursor temperatures(log.temperature.time);
  MotionSeries motion;
  motion.reserve(joints.time.size());
  for (std::size_t i = 0; i < joints.time.size(); ++i) {
    if (i > 0 && !(joints.time[i] > motion.back().time)) continue;  // a repeated stamp brings nothing new
    MeasuredMotion at;
    at.time = joints.time[i];
    at.carriage_position = joints.carriage_position[i];
    at.carriage_velocity = velocity[i];
    at.wheel_angle = joints.wheel_angle[i];
    at.wheel_rate = rate[i];
    at.load = conditions.load;
    at.steering_angle = conditions.steering_angle;
    at.temperature = log.temperature.value.empty()
                         ? conditions.temperature
                         : interpolated(log.temperature.value, temperatures.at(at.time));
    motion.push_back(at);
  }
  return motion;
}

Prediction predict(const RigSettings& settings, const RunConditions& conditions, double radius,
                   Contact& contact, const Ports& ports, const MotionSeries& motion, const SampleTimes& times,
                   const ReplayOptions& options) {
  if (motion.empty()) throw Error("replay: the measured motion is empty");
  Replay replay(settings, conditions, radius, contact, ports, options);
  std::vector<double> motion_times;
  motion_times.reserve(motion.size());
  for (const MeasuredMotion& at : motion) motion_times.push_back(at.time);

  const double start = motion_times.front();
  const double span = motion_times.back() - start;
  const auto steps = static_cast<std::size_t>(std::ceil(span / options.step - 1e-9));
  std::vector<double> step_times;
  std::vector<Eigen::Vector3d> force;
  std::vector<Eigen::Vector3d> torque;
  std::vector<double> displacement;
  std::vector<double> effort;
  for (auto* series : {&displacement, &effort, &step_times}) series->reserve(steps + 1);
  force.reserve(steps + 1);
  torque.reserve(steps + 1);
  Cursor cursor(motion_times);
  for (std::size_t i = 0; i <= steps; ++i) {
    const double time = i < steps ? start + static_cast<double>(i) * options.step : motion_times.back();
    const auto [index, share] = cursor.at(time);
    MeasuredMotion at = share > 0.0 ? between(motion[index], motion[index + 1], share) : motion[index];
    at.time = time;
    const Readings& readings = replay.update(at).readings;
    step_times.push_back(time);
    force.push_back(readings.wrench.force);
    torque.push_back(readings.wrench.torque);
    displacement.push_back(readings.displacement);
    effort.push_back(readings.joints.wheel_effort);
  }

  Prediction prediction;
  Cursor wrench_cursor(step_times);
  for (const double time : times.wrench) {
    const auto place = wrench_cursor.at(time);
    prediction.wrench.push_back({interpolated(force, place), interpolated(torque, place)});
  }
  Cursor displacement_cursor(step_times);
  for (const double time : times.displacement)
    prediction.displacement.push_back(
        interpolated(displacement, displacement_cursor.at(time - replay.draw_wire_delay())));
  Cursor effort_cursor(step_times);
  for (const double time : times.effort)
    prediction.effort.push_back(interpolated(effort, effort_cursor.at(time)));
  return prediction;
}

}  // namespace wheel_twin::rig
