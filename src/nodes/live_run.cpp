#include "nodes/live_run.h"

#include <algorithm>
#include <chrono>

namespace wheel_twin::nodes {
namespace {

constexpr double bias_window = 0.1;  // s of readings that a tare averages

}  // namespace

const char* to_string(Phase phase) {
  switch (phase) {
    case Phase::lowering:
      return "lowering";
    case Phase::dwell:
      return "dwell";
    case Phase::ramp_up:
      return "ramp up";
    case Phase::steady:
      return "steady";
    case Phase::ramp_down:
      return "ramp down";
    case Phase::rest:
      return "rest";
    case Phase::over:
      break;
  }
  return "over";
}

Phase phase_at(const std::optional<rig::Timeline>& timeline, double time) {
  if (!timeline || time < timeline->handed_over) return Phase::lowering;
  if (time < timeline->ramp_up) return Phase::dwell;
  if (time < timeline->steady) return Phase::ramp_up;
  if (time < timeline->ramp_down) return Phase::steady;
  if (time < timeline->rest) return Phase::ramp_down;
  return time < timeline->end ? Phase::rest : Phase::over;
}

LiveRun::LiveRun(const rig::RunSettings& settings, rig::Contact& contact, const rig::Ports& ports,
                 const std::string& bag)
    : run_(settings, contact, ports),
      recent_limit_(static_cast<std::size_t>(std::max(1.0, bias_window * settings.sensors.ft.rate))) {
  if (!bag.empty()) bag_ = std::make_unique<logs::BagWriter>(bag, settings.epoch);
}

LiveRun::~LiveRun() = default;

Phase LiveRun::phase() const {
  return done() ? Phase::over : phase_at(run_.timeline(), run_.time());
}

run_log::RunLog LiveRun::advance(double until, double patience) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(patience);
  do {
    run_.advance();
  } while (!run_.done() && run_.time() < until && Clock::now() < deadline);
  run_log::RunLog log = run_.take_log();
  tare(log);
  write(log);
  return log;
}

void LiveRun::tare(run_log::RunLog& log) {
  for (std::size_t i = 0; i < log.ft.time.size(); ++i) {
    recent_.push_back({log.ft.force[i], log.ft.torque[i]});
    if (recent_.size() > recent_limit_) recent_.pop_front();
    log.ft.force[i] -= bias_.force;
    log.ft.torque[i] -= bias_.torque;
  }
}

bool LiveRun::bias() {
  if (recent_.empty()) return false;
  rig::WrenchReading mean;
  for (const auto& reading : recent_) {
    mean.force += reading.force;
    mean.torque += reading.torque;
  }
  mean.force /= static_cast<double>(recent_.size());
  mean.torque /= static_cast<double>(recent_.size());
  bias_ = mean;
  return true;
}

void LiveRun::write(const run_log::RunLog& log) {
  messages_ +=
      log.ft.time.size() + log.draw_wire.time.size() + log.joints.time.size() + log.temperature.time.size();
  if (!bag_) return;
  for (std::size_t i = 0; i < log.ft.time.size(); ++i)
    bag_->wrench(log.ft.time[i], log.ft.force[i], log.ft.torque[i]);
  for (std::size_t i = 0; i < log.draw_wire.time.size(); ++i)
    bag_->displacement(log.draw_wire.time[i], log.draw_wire.value[i]);
  const auto& joints = log.joints;
  for (std::size_t i = 0; i < joints.time.size(); ++i)
    bag_->joints(joints.time[i], {joints.carriage_position[i], joints.carriage_velocity[i],
                                  joints.wheel_angle[i], joints.wheel_rate[i], joints.wheel_effort[i]});
  for (std::size_t i = 0; i < log.temperature.time.size(); ++i)
    bag_->temperature(log.temperature.time[i], log.temperature.value[i]);
}

void LiveRun::stop() {
  run_.stop();
}

void LiveRun::close() {
  if (bag_) bag_->close();
}

}  // namespace wheel_twin::nodes
