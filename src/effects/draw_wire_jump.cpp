// A spool that skips: the draw wire reads `step` more from `time` after the start of each run; the skip takes
// half a second.
#include <algorithm>

#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class DrawWireJump final : public Effect, public rig::SensorPort {
 public:
  explicit DrawWireJump(const std::vector<double>& values) : step_(values[0]), time_(values[1]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_displacement(const rig::RigState& state, double /*normal_load*/,
                           double& displacement) const override {
    displacement += step_ * std::clamp((state.time - time_) / duration + 0.5, 0.0, 1.0);
  }

 private:
  static constexpr double duration = 0.5;  // s
  double step_;
  double time_;
};

}  // namespace

EffectType draw_wire_jump() {
  return {"draw_wire_jump",
          Place::sensor,
          {{"step", "m", -0.1, 0.1, 0.002, 0.0}, {"time", "s", 0.0, 1000.0, 10.0, shape_parameter}},
          "Check that the wire lies in one layer on its spool and that nothing touches it along its way.",
          "A buried rock moves the hub too, but forces as well, and lets it down again.",
          construct<DrawWireJump>};
}

}  // namespace wheel_twin::effects
