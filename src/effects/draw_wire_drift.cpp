// A draw-wire reading that creeps: a wire that slips on its spool or stretches, an encoder that loses counts.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class DrawWireDrift final : public Effect, public rig::SensorPort {
 public:
  explicit DrawWireDrift(const std::vector<double>& values) : rate_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_displacement(const rig::RigState& state, double /*normal_load*/,
                           double& displacement) const override {
    displacement += rate_ * state.time;
  }

 private:
  double rate_;
};

}  // namespace

EffectType draw_wire_drift() {
  return {"draw_wire_drift",
          Place::sensor,
          {{"rate", "m/s", -0.001, 0.001, 2e-5, 0.0}},
          "Hold the wheel at a fixed height for the length of a run and watch the reading.",
          "A tilted bed moves the hub with distance, this with time: runs of different slip separate them.",
          construct<DrawWireDrift>};
}

}  // namespace wheel_twin::effects
