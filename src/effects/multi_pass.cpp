// A bed compacted by an earlier pass: stiffness times 1 + stiffening.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class MultiPass final : public Effect, public rig::SoilPort {
 public:
  explicit MultiPass(const std::vector<double>& values) : stiffening_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  double stiffness_factor(const rig::RigState&) const override { return 1.0 + stiffening_; }

 private:
  double stiffening_;
};

}  // namespace

EffectType multi_pass() {
  return {"multi_pass",
          Place::soil,
          {{"stiffening", "fraction", -0.9, 10.0, 0.4, 0.0}},
          "Loosen and level the bed before each run.",
          "Looks like an offset of the draw wire; drawbar pull changes with it.",
          construct<MultiPass>};
}

}  // namespace wheel_twin::effects
