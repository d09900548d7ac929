// Draw-wire stamps later than the measurement by a constant.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class ClockSkew final : public Effect, public rig::SensorPort {
 public:
  explicit ClockSkew(const std::vector<double>& values) : offset_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  double draw_wire_delay() const override { return offset_; }

 private:
  double offset_;
};

}  // namespace

EffectType clock_skew() {
  return {"clock_skew",
          Place::log,
          {{"offset", "s", -5.0, 5.0, 0.1, 0.0}},
          "Synchronise the clocks of the recorders, or stamp all sensors on one machine.",
          "Needs a transient that both force and displacement show.",
          construct<ClockSkew>};
}

}  // namespace wheel_twin::effects
