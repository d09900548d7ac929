#include "rig/joint_sensor.h"

namespace wheel_twin::rig {
namespace {

double between(double from, double to, double share) {
  return from + share * (to - from);
}

double noisy(double value, double noise, Random& random) {
  return noise > 0.0 ? value + noise * random.normal() : value;
}

}  // namespace

JointSensor::JointSensor(const JointSettings& settings, std::uint64_t seed)
    : settings_(settings), random_(seed, 3), clock_(settings.rate) {}

void JointSensor::observe(double time, const JointReading& signal, run_log::JointSeries& series) {
  const JointReading from = started_ ? last_ : signal;
  clock_.until(time, [&](double due, double share) {
    const auto at = [&](double JointReading::*member) {
      return between(from.*member, signal.*member, share);
    };
    series.time.push_back(due);
    series.carriage_position.push_back(
        quantised(at(&JointReading::carriage_position), settings_.carriage_resolution));
    series.carriage_velocity.push_back(
        noisy(at(&JointReading::carriage_velocity), settings_.carriage_velocity_noise, random_));
    series.wheel_angle.push_back(quantised(at(&JointReading::wheel_angle), settings_.wheel_resolution));
    series.wheel_rate.push_back(noisy(at(&JointReading::wheel_rate), settings_.wheel_rate_noise, random_));
    series.wheel_effort.push_back(
        quantised(noisy(at(&JointReading::wheel_effort), settings_.effort_noise, random_),
                  settings_.effort_resolution));
  });
  started_ = true;
  last_ = signal;
}

Thermometer::Thermometer(const TemperatureSettings& settings, std::uint64_t seed)
    : settings_(settings), random_(seed, 4), clock_(settings.rate) {}

void Thermometer::observe(double time, double celsius, run_log::ScalarSeries& series) {
  clock_.until(time, [&](double due, double) {
    series.time.push_back(due);
    series.value.push_back(quantised(noisy(celsius, settings_.noise, random_), settings_.resolution));
  });
}

}  // namespace wheel_twin::rig
