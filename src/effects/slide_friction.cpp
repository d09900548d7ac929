// Coulomb friction in the vertical guide: it holds the slide back from sinking and from rising.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class SlideFriction final : public Effect, public rig::RigPort {
 public:
  explicit SlideFriction(const std::vector<double>& values) : coulomb_force_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.rig.push_back(this); }

  double coulomb_friction(const rig::RigState&) const override { return coulomb_force_; }

 private:
  double coulomb_force_;
};

}  // namespace

EffectType slide_friction() {
  return {
      "slide_friction",
      Place::rig,
      {{"coulomb_force", "N", 0.0, 40.0, 3.0, 0.0}},
      "Clean and lubricate the vertical guide; move the slide by hand with a spring balance, up and down.",
      "While the wheel sinks it looks like a lighter dead weight; the sign changes with the direction of "
      "motion.",
      construct<SlideFriction>};
}

}  // namespace wheel_twin::effects
