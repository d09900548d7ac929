// A soil surface that rises along the travel.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class BedTilt final : public Effect, public rig::SoilPort {
 public:
  explicit BedTilt(const std::vector<double>& values) : angle_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  double surface_slope(const rig::RigState&) const override { return angle_; }

 private:
  double angle_;
};

}  // namespace

EffectType bed_tilt() {
  return {"bed_tilt",
          Place::rig,
          {{"angle", "rad", -0.3, 0.3, 0.02, 0.0}},
          "Level the bed, or the guide: measure the distance of the surface to the guide at both ends.",
          "Drawbar pull alone looks like ft_misalignment; the hub rises with distance only here.",
          construct<BedTilt>};
}

}  // namespace wheel_twin::effects
