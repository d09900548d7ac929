#include "rig/instruments.h"

#include <utility>

#include "base/error.h"
#include "rig/draw_wire.h"
#include "rig/ft_sensor.h"
#include "rig/joint_sensor.h"

namespace wheel_twin::rig {

class Instruments::Impl {
 public:
  Impl(const SensorSettings& settings, std::uint64_t seed, double epoch)
      : ft_(settings.ft, seed),
        draw_wire_(settings.draw_wire, seed),
        joints_(settings.joints, seed),
        thermometer_(settings.temperature, seed) {
    if (!(epoch > 0.0)) throw Error("the epoch of a run must be above ROS time 0");
    log_.epoch = epoch;
  }

  void observe(const RigStep& step, double draw_wire_delay) {
    const double time = step.state.time;
    ft_.observe(time, step.readings.wrench, log_.ft);
    draw_wire_.observe(time, step.readings.displacement, draw_wire_delay, log_.draw_wire);
    joints_.observe(time, step.readings.joints, log_.joints);
    thermometer_.observe(time, step.readings.temperature, log_.temperature);
  }

  run_log::RunLog take() {
    run_log::RunLog log;
    log.epoch = log_.epoch;
    std::swap(log, log_);
    return log;
  }

 private:
  FtSensor ft_;
  DrawWire draw_wire_;
  JointSensor joints_;
  Thermometer thermometer_;
  run_log::RunLog log_;
};

Instruments::Instruments(const SensorSettings& settings, std::uint64_t seed, double epoch)
    : impl_(std::make_unique<Impl>(settings, seed, epoch)) {}
Instruments::~Instruments() = default;
Instruments::Instruments(Instruments&&) noexcept = default;

void Instruments::observe(const RigStep& step, double draw_wire_delay) {
  impl_->observe(step, draw_wire_delay);
}
run_log::RunLog Instruments::take() {
  return impl_->take();
}

}  // namespace wheel_twin::rig
