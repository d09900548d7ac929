// Soil that slip loosens: sinkage grows by 1 + gain slip, approached exponentially over a length of rim
// travel.
#include "effects/catalogue.h"

#include <cmath>

namespace wheel_twin::effects {
namespace {

class SlipSinkage final : public Effect, public rig::SoilPort {
 public:
  explicit SlipSinkage(const std::vector<double>& values) : gain_(values[0]), length_(values[1]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  double sinkage_factor(const rig::RigState& state) const override {
    return 1.0 + gain_ * std::abs(state.slip) * (1.0 - std::exp(-state.rim_travel / length_));
  }

 private:
  double gain_;
  double length_;
};

}  // namespace

EffectType slip_sinkage() {
  return {"slip_sinkage",
          Place::soil,
          {{"gain", "1", -0.9, 8.0, 0.5, 0.0}, {"length", "m", 0.002, 3.0, 0.1, shape_parameter}},
          "Compare sinkage after one, two and three turns of the wheel; model the soil transport by slip.",
          "Needs runs at several slips; its start-up over rim travel separates it from a softer soil.",
          construct<SlipSinkage>};
}

}  // namespace wheel_twin::effects
