// A bed whose stiffness changes along the travel: times 1 + slope x from the start of the run.
#include "effects/catalogue.h"

#include <algorithm>

namespace wheel_twin::effects {
namespace {

class DensityGradient final : public Effect, public rig::SoilPort {
 public:
  explicit DensityGradient(const std::vector<double>& values) : slope_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  double stiffness_factor(const rig::RigState& state) const override {
    return std::max(0.05, 1.0 + slope_ * state.x);
  }

 private:
  double slope_;
};

}  // namespace

EffectType density_gradient() {
  return {"density_gradient",
          Place::soil,
          {{"slope", "1/m", -0.95, 5.0, 0.3, 0.0}},
          "Prepare the bed evenly; measure penetration along the bed.",
          "Looks like a drift of the draw wire; forces change with it.",
          construct<DensityGradient>};
}

}  // namespace wheel_twin::effects
