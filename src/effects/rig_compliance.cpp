// A frame that yields: displacement read too large by compliance times load.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class RigCompliance final : public Effect, public rig::SensorPort {
 public:
  explicit RigCompliance(const std::vector<double>& values) : vertical_compliance_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_displacement(const rig::RigState&, double normal_load, double& displacement) const override {
    displacement += vertical_compliance_ * normal_load;
  }

 private:
  double vertical_compliance_;
};

}  // namespace

EffectType rig_compliance() {
  return {
      "rig_compliance",
      Place::rig,
      {{"vertical_compliance", "m/N", 0.0, 0.001, 0.00003, 0.0}},
      "Press the wheel on a rigid floor and compare draw wire and load.",
      "On one load it looks like draw_wire_offset; two loads separate them, or logs that begin with a wheel "
      "that hangs free.",
      construct<RigCompliance>};
}

}  // namespace wheel_twin::effects
