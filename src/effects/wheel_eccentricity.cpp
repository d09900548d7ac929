// A hub off the centre of the rim: it rises by amplitude cos(wheel angle + phase).
#include "effects/catalogue.h"

#include <cmath>

namespace wheel_twin::effects {
namespace {

class WheelEccentricity final : public Effect, public rig::WheelPort {
 public:
  explicit WheelEccentricity(const std::vector<double>& values) : amplitude_(values[0]), phase_(values[1]) {}

  void attach(rig::Ports& ports) const override { ports.wheel.push_back(this); }

  double hub_rise(const rig::RigState& state) const override {
    return amplitude_ * std::cos(state.wheel_angle + phase_);
  }

 private:
  double amplitude_;
  double phase_;
};

}  // namespace

EffectType wheel_eccentricity() {
  return {"wheel_eccentricity",
          Place::wheel,
          {{"amplitude", "m", 0.0, 0.02, 0.001, 0.0},
           {"phase", "rad", -3.141592653589793, 3.141592653589793, 1.8, shape_parameter, true}},
          "Turn the wheel by hand against a dial gauge.",
          "A soft spoke gives a short dip instead of a cosine.",
          construct<WheelEccentricity>};
}

}  // namespace wheel_twin::effects
