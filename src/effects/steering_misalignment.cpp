// A wheel turned to the left by an angle that nobody declared.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class SteeringMisalignment final : public Effect, public rig::RigPort {
 public:
  explicit SteeringMisalignment(const std::vector<double>& values) : angle_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.rig.push_back(this); }

  double added_steering(const rig::RigState&) const override { return angle_; }

 private:
  double angle_;
};

}  // namespace

EffectType steering_misalignment() {
  return {"steering_misalignment",
          Place::rig,
          {{"angle", "rad", -0.45, 0.45, 0.03, 0.0}},
          "Align the wheel with the guide, or measure its steering angle.",
          "Side force alone looks like a roll of the sensor; the angle scales with slip and direction.",
          construct<SteeringMisalignment>};
}

}  // namespace wheel_twin::effects
