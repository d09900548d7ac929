// Force readings that creep linearly with time from the start of a run.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class FtDrift final : public Effect, public rig::SensorPort {
 public:
  explicit FtDrift(const std::vector<double>& values) : rate_(values[0], values[1], values[2]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_wrench(const rig::RigState& state, rig::WrenchReading& reading) const override {
    reading.force += rate_ * state.time;
  }

 private:
  Eigen::Vector3d rate_;
};

}  // namespace

EffectType ft_drift() {
  return {"ft_drift",
          Place::sensor,
          {{"rate_x", "N/s", -1.0, 1.0, 0.02, 0.0},
           {"rate_y", "N/s", -1.0, 1.0, 0.02, 0.0},
           {"rate_z", "N/s", -1.0, 1.0, 0.02, 0.0}},
          "Let the sensor warm up, tare before each run, compare a tare before and after a run.",
          "Needs long runs; with the temperature logged it separates from ft_thermal.",
          construct<FtDrift>};
}

}  // namespace wheel_twin::effects
