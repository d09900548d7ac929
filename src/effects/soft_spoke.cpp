// A weak part of a flexible wheel: the hub drops by extra_deflection exp(-(a/half_angle)^2/2), a = wheel
// angle + phase wrapped to (-pi, pi].
#include "effects/catalogue.h"

#include <cmath>

namespace wheel_twin::effects {
namespace {

constexpr double pi = 3.141592653589793;

class SoftSpoke final : public Effect, public rig::WheelPort {
 public:
  explicit SoftSpoke(const std::vector<double>& values)
      : extra_deflection_(values[0]), half_angle_(values[1]), phase_(values[2]) {}

  void attach(rig::Ports& ports) const override { ports.wheel.push_back(this); }

  double hub_rise(const rig::RigState& state) const override {
    const double a = std::remainder(state.wheel_angle + phase_, 2.0 * pi);
    const double u = a / half_angle_;
    return -extra_deflection_ * std::exp(-0.5 * u * u);
  }

 private:
  double extra_deflection_;
  double half_angle_;
  double phase_;
};

}  // namespace

EffectType soft_spoke() {
  return {"soft_spoke",
          Place::wheel,
          {{"extra_deflection", "m", 0.0, 0.02, 0.001, 0.0},
           {"half_angle", "rad", 0.05, 1.6, 0.3, shape_parameter},
           {"phase", "rad", -3.141592653589793, 3.141592653589793, 1.8, shape_parameter, true}},
          "Press each spoke in turn with a known load; look for a crack or a loose clamp.",
          "A wide soft spoke looks like wheel_eccentricity: the second harmonic of the wheel angle separates "
          "them.",
          construct<SoftSpoke>};
}

}  // namespace wheel_twin::effects
