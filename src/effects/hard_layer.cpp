// A hard floor or layer under the soil: stiffness times 1 + (z / depth)^3.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class HardLayer final : public Effect, public rig::SoilPort {
 public:
  explicit HardLayer(const std::vector<double>& values) : depth_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  bool layered() const override { return true; }
  double layer_factor(const rig::RigState&, double depth) const override {
    const double ratio = depth / depth_;
    return 1.0 + ratio * ratio * ratio;
  }

 private:
  double depth_;
};

}  // namespace

EffectType hard_layer() {
  return {"hard_layer",
          Place::soil,
          {{"depth", "m", 0.002, 1.0, 0.05, 1.0}},
          "Fill the bin deeper, or measure the depth to the floor.",
          "Needs runs of different sinkage (loads or slips).",
          construct<HardLayer>};
}

}  // namespace wheel_twin::effects
