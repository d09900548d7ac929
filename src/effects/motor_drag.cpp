// A torque that the motor sees and the soil does not: bearings, seals, gear.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class MotorDrag final : public Effect, public rig::RigPort {
 public:
  explicit MotorDrag(const std::vector<double>& values) : torque_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.rig.push_back(this); }

  double motor_drag(const rig::RigState&) const override { return torque_; }

 private:
  double torque_;
};

}  // namespace

EffectType motor_drag() {
  return {"motor_drag",
          Place::rig,
          {{"torque", "N m", 0.0, 20.0, 0.3, 0.0}},
          "Turn the wheel in the air at test speed and read the motor effort.",
          "Forces do not change: only motor effort does.",
          construct<MotorDrag>};
}

}  // namespace wheel_twin::effects
