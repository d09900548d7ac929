// A draw-wire reading with a wrong zero.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class DrawWireOffset final : public Effect, public rig::SensorPort {
 public:
  explicit DrawWireOffset(const std::vector<double>& values) : offset_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_displacement(const rig::RigState&, double /*normal_load*/,
                           double& displacement) const override {
    displacement += offset_;
  }

 private:
  double offset_;
};

}  // namespace

EffectType draw_wire_offset() {
  return {"draw_wire_offset",
          Place::sensor,
          {{"offset", "m", -0.1, 0.1, 0.002, 0.0}},
          "Set the zero at first touch of the undisturbed soil again.",
          "A soil softer by a constant amount looks alike on one load; forces do not change with the offset. "
          "Logs that begin with the wheel hanging free show it at first touch.",
          construct<DrawWireOffset>};
}

}  // namespace wheel_twin::effects
