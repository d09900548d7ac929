// A force that deforming the wheel takes off the drawbar pull while it rolls (the paper's R_f).
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class WheelFlexingResistance final : public Effect, public rig::WheelPort {
 public:
  explicit WheelFlexingResistance(const std::vector<double>& values) : force_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.wheel.push_back(this); }

  double rolling_resistance(const rig::RigState&) const override { return force_; }

 private:
  double force_;
};

}  // namespace

EffectType wheel_flexing_resistance() {
  return {"wheel_flexing_resistance",
          Place::wheel,
          {{"force", "N", 0.0, 30.0, 2.0, 0.0}},
          "Roll the wheel on a hard floor under load and read the pull and the motor effort.",
          "A constant off the drawbar pull while rolling, none at rest: ft_bias stays at rest.",
          construct<WheelFlexingResistance>};
}

}  // namespace wheel_twin::effects
