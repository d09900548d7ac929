// Cohesion on top of the declared or calibrated one: moist or crusted soil.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class SoilCohesion final : public Effect, public rig::SoilPort {
 public:
  explicit SoilCohesion(const std::vector<double>& values) : cohesion_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  double added_cohesion(const rig::RigState&) const override { return cohesion_; }

 private:
  double cohesion_;
};

}  // namespace

EffectType soil_cohesion() {
  return {
      "soil_cohesion",
      Place::soil,
      {{"cohesion", "Pa", 0.0, 20000.0, 500.0, 0.0}},
      "Measure the moisture of the soil; dry it or declare its cohesion.",
      "Acts on drawbar pull and torque with slip, like a larger angle of friction; two loads separate them.",
      construct<SoilCohesion>};
}

}  // namespace wheel_twin::effects
