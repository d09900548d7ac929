// Soil that a braked wheel pushes ahead: a bow wave against its front, which grows with its depth and skid.
//   force = coefficient z^2 sqrt(-s) against the travel for s < 0, z the hub displacement.
// Passive pressure of a blade of the wheel's width b in soil of weight density g_s is N g_s b / 2 z^2
// (Rankine; N of 10 to 30 for a curved blade with a pile before it), so that coefficient = N g_s b / 2; the
// root of the skid is a fit to the logs of a real single-wheel testbed (doc/validation.md).
#include "effects/catalogue.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::effects {
namespace {

class Bulldozing final : public Effect, public rig::SoilPort {
 public:
  explicit Bulldozing(const std::vector<double>& values) : coefficient_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  Eigen::Vector3d added_force(const rig::RigState& state, double normal_load) const override {
    if (state.slip >= 0.0 || normal_load <= 0.0) return Eigen::Vector3d::Zero();
    const double z = std::max(0.0, state.hub_displacement);
    const double direction = state.carriage_speed < 0.0 ? 1.0 : -1.0;
    return {direction * coefficient_ * z * z * std::sqrt(-state.slip), 0.0, 0.0};
  }

 private:
  double coefficient_;
};

}  // namespace

EffectType bulldozing() {
  return {"bulldozing",
          Place::soil,
          {{"coefficient", "N/m^2", 0.0, 60000.0, 8000.0, 0.0}},
          "Photograph the soil before the wheel at the end of a braked run; compare runs with the pile taken "
          "away.",
          "Needs braked runs of several skids; at one skid a higher compaction resistance looks the same.",
          construct<Bulldozing>};
}

}  // namespace wheel_twin::effects
