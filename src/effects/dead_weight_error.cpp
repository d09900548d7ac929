// A dead weight that differs from the declared load.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class DeadWeightError final : public Effect, public rig::RigPort {
 public:
  explicit DeadWeightError(const std::vector<double>& values) : force_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.rig.push_back(this); }

  double added_dead_weight(const rig::RigState&) const override { return force_; }

 private:
  double force_;
};

}  // namespace

EffectType dead_weight_error() {
  return {"dead_weight_error",
          Place::rig,
          {{"force", "N", -60.0, 60.0, 3.0, 0.0}},
          "Weigh the slide with everything that hangs on it.",
          "Seen by normal load, drawbar pull and sinkage at once; ft_bias changes one reading only.",
          construct<DeadWeightError>};
}

}  // namespace wheel_twin::effects
