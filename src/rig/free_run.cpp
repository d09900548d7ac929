#include "rig/free_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "rig/draw_wire_pull.h"

namespace wheel_twin::rig {
namespace {

constexpr double slack_before_hand_over = 0.1;  // s that the hoist's rope must hang slack

}  // namespace

class FreeRun::Impl {
 public:
  Impl(const RunSettings& settings, Contact& contact, Ports ports)
      : settings_(settings),
        speeds_(speeds_of_slip(settings.conditions.slip, settings.conditions.wheel_speed, settings.radius)),
        pull_(settings.sensors.draw_wire),
        rig_(settings.rig, settings.conditions, settings.radius, contact, with_pull(std::move(ports))),
        instruments_(settings.sensors, settings.seed, settings.epoch) {
    if (!(settings_.step > 0.0) || settings_.step > 0.01)
      throw Error(
          fmt::format("a step of {} s: a free run needs one above 0 and at most 0.01 s", settings_.step));
    if (settings_.conditions.towed) speeds_ = {settings_.radius * settings_.conditions.wheel_speed, 0.0};
    const Timeline shortest = rig::timeline(settings_.profile, speeds_, 0.0);
    const double travel =
        std::abs(speeds_.carriage) * (shortest.ramp_down - shortest.steady + settings_.profile.ramp);
    if (travel > settings_.rig.carriage.stroke)
      throw Error(
          fmt::format("the run travels {:.3g} m, the carriage has {:.3g} m: shorten the profile's travel or "
                      "longest_steady",
                      travel, settings_.rig.carriage.stroke));
    instruments_.observe(rig_.start(-settings_.profile.clearance), rig_.draw_wire_delay());
  }

  bool done() const { return timeline_ && time() >= timeline_->end - 0.5 * settings_.step; }
  double time() const { return static_cast<double>(steps_) * settings_.step; }

  double expected_end() const {
    if (timeline_) return timeline_->end;
    const double lowering =
        (settings_.profile.clearance + settings_.rig.slide.travel_below) / settings_.profile.lowering_speed;
    return rig::timeline(settings_.profile, speeds_, lowering).end;
  }

  const std::optional<Timeline>& timeline() const { return timeline_; }
  const RigStep& step() const { return rig_.step(); }
  run_log::RunLog take_log() { return instruments_.take(); }

  const RigStep& advance() {
    ++steps_;
    Command command;
    if (timeline_) {
      const double share = stop_share_ * speed_share(*timeline_, time());
      command.carriage_speed = share * speeds_.carriage;
      command.wheel_rate = share * speeds_.wheel;
    } else {
      command.lowest_slide_velocity = -settings_.profile.lowering_speed;
    }
    const RigStep& step = rig_.advance(command, settings_.step);
    if (!timeline_) watch_the_hoist(step);
    instruments_.observe(step, rig_.draw_wire_delay());
    return step;
  }

  void stop() {
    if (!timeline_) {  // the wheel stays on the hoist
      timeline_ = Timeline{time(), time(), time(), time(), time(), time()};
      return;
    }
    if (time() >= timeline_->ramp_down) return;
    stop_share_ = speed_share(*timeline_, time());
    timeline_->ramp_up = std::min(timeline_->ramp_up, time());
    timeline_->steady = std::min(timeline_->steady, time());
    timeline_->ramp_down = time();
    timeline_->rest = time() + settings_.profile.ramp;
    timeline_->end = timeline_->rest + settings_.profile.rest;
  }

 private:
  Ports with_pull(Ports ports) {
    ports.rig.push_back(&pull_);
    return ports;
  }

  void watch_the_hoist(const RigStep& step) {
    if (step.hoist_taut) {
      slack_since_ = time();
    } else if (time() - slack_since_ >= slack_before_hand_over) {
      if (step.load.force_hub_rig.z() <= 0.0)
        throw Error(
            fmt::format("the wheel hangs in the guide, {:.1f} mm above the soil: friction carries its load",
                        -1e3 * step.state.hub_displacement));
      timeline_ = rig::timeline(settings_.profile, speeds_, time());
    }
  }

  RunSettings settings_;
  Speeds speeds_;
  DrawWirePull pull_;
  Rig rig_;
  Instruments instruments_;
  std::optional<Timeline> timeline_;
  std::uint64_t steps_ = 0;
  double slack_since_ = 0.0;
  double stop_share_ = 1.0;
};

FreeRun::FreeRun(const RunSettings& settings, Contact& contact, const Ports& ports)
    : impl_(std::make_unique<Impl>(settings, contact, ports)) {}
FreeRun::~FreeRun() = default;
FreeRun::FreeRun(FreeRun&&) noexcept = default;

bool FreeRun::done() const {
  return impl_->done();
}
double FreeRun::time() const {
  return impl_->time();
}
double FreeRun::expected_end() const {
  return impl_->expected_end();
}
const std::optional<Timeline>& FreeRun::timeline() const {
  return impl_->timeline();
}
const RigStep& FreeRun::advance() {
  return impl_->advance();
}
const RigStep& FreeRun::step() const {
  return impl_->step();
}
void FreeRun::stop() {
  impl_->stop();
}
run_log::RunLog FreeRun::take_log() {
  return impl_->take_log();
}

run_log::RunLog run_to_end(FreeRun& run, RunSummary& summary, const std::vector<Observer>& observers) {
  summary = {};
  double count = 0.0;
  for (const Observer& observer : observers) observer(run.step());
  while (!run.done()) {
    const RigStep& step = run.advance();
    for (const Observer& observer : observers) observer(step);
    if (!run.timeline()) continue;
    summary.window[0] = 0.5 * (run.timeline()->steady + run.timeline()->ramp_down);
    summary.window[1] = run.timeline()->ramp_down;
    if (step.state.time < summary.window[0] || step.state.time > summary.window[1]) continue;
    count += 1.0;
    const auto average = [&](double& mean, double value) { mean += (value - mean) / count; };
    average(summary.drawbar_pull, step.load.force_hub_rig.x());
    average(summary.side_force, step.load.force_hub_rig.y());
    average(summary.normal_load, step.load.force_hub_rig.z());
    average(summary.hub_displacement, step.state.hub_displacement);
    average(summary.drive_torque, step.load.drive_torque);
    average(summary.motor_effort, step.readings.joints.wheel_effort);
    average(summary.slip, step.state.slip);
  }
  return run.take_log();
}

}  // namespace wheel_twin::rig
