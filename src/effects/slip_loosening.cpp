// Soil that the slipping wheel shears loose under itself: its stiffness falls with slip, so that the wheel
// sinks until the deeper and longer contact carries it, and the resultant turns with it. Stiffness times
//   1 / (1 + driving_gain (1 - (1 - s)^driving_shape) / driving_shape)   for s > 0 (Box-Cox of 1 - s: a shape
//     of 1 grows linearly, above 1 levels off as a smooth rim does, below 0 grows without bound towards
//     s = 1, as grousers dig),
//   1 / (1 + braking_gain |s|^2.5)                                       for s < 0 (the power is that of the
//   logs).
// Found in the logs of a real single-wheel testbed (doc/validation.md).
#include "effects/catalogue.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::effects {
namespace {

class SlipLoosening final : public Effect, public rig::SoilPort {
 public:
  explicit SlipLoosening(const std::vector<double>& values)
      : driving_gain_(values[0]), driving_shape_(values[1]), braking_gain_(values[2]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  double stiffness_factor(const rig::RigState& state) const override {
    const double s = state.slip;
    if (s < 0.0) return 1.0 / (1.0 + braking_gain_ * s * s * std::sqrt(-s));
    // A wheel that spins on the spot would dig for ever where the shape is at most 0.
    const double left = std::log1p(-std::min(s, 0.99));
    const double loosened =
        std::abs(driving_shape_) < 1e-6 ? -left : -std::expm1(driving_shape_ * left) / driving_shape_;
    return 1.0 / (1.0 + driving_gain_ * loosened);
  }

 private:
  double driving_gain_;
  double driving_shape_;
  double braking_gain_;
};

}  // namespace

EffectType slip_loosening() {
  return {"slip_loosening",
          Place::soil,
          {{"driving_gain", "1", 0.0, 20.0, 2.0, 0.0},
           {"driving_shape", "1", -1.5, 5.0, 1.5, shape_parameter},
           {"braking_gain", "1", 0.0, 40.0, 5.0, 0.0}},
          "Compare the depth of the rut after runs at several slips; measure the density under it.",
          "Needs runs at several slips of both signs. slip_sinkage lowers the hub and leaves the drawbar "
          "pull; this changes both.",
          construct<SlipLoosening>};
}

}  // namespace wheel_twin::effects
