// A draw-wire reading too large by a fraction: wrong drum or pulse count.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class DrawWireScale final : public Effect, public rig::SensorPort {
 public:
  explicit DrawWireScale(const std::vector<double>& values) : scale_error_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_displacement(const rig::RigState&, double /*normal_load*/,
                           double& displacement) const override {
    displacement *= 1.0 + scale_error_;
  }

 private:
  double scale_error_;
};

}  // namespace

EffectType draw_wire_scale() {
  return {"draw_wire_scale",
          Place::sensor,
          {{"scale_error", "fraction", -0.9, 1.0, 0.05, 0.0}},
          "Compare the draw wire with a gauge block over its range.",
          "Separates from draw_wire_offset by runs of different sinkage.",
          construct<DrawWireScale>};
}

}  // namespace wheel_twin::effects
