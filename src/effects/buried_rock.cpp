// Something hard in the bed: stiffness times 1 + stiffening b, b = exp(-((x - position) / half_width)^2 / 2),
// and in the way. Lifting the load over it costs drawbar pull ahead of it and gives it back behind, load
// times the slope of the path that the hub takes (sinkage goes with stiffness to the power -2/3 for a rigid
// wheel and n = 1), as far as the soil does (`climbing`: 1 all of it, 0 none); pushing past it costs
// `resistance` times b.
#include "effects/catalogue.h"

#include <cmath>

namespace wheel_twin::effects {
namespace {

class BuriedRock final : public Effect, public rig::SoilPort {
 public:
  explicit BuriedRock(const std::vector<double>& values)
      : position_(values[0]),
        half_width_(values[1]),
        stiffening_(values[2]),
        climbing_(values[3]),
        resistance_(values[4]) {}

  void attach(rig::Ports& ports) const override { ports.soil.push_back(this); }

  double stiffness_factor(const rig::RigState& state) const override {
    return 1.0 + stiffening_ * bump(state.x);
  }
  Eigen::Vector3d added_force(const rig::RigState& state, double normal_load) const override {
    const double b = bump(state.x);
    const double slope_of_stiffness = -stiffening_ * b * (state.x - position_) / (half_width_ * half_width_);
    const double rise_per_metre =
        (2.0 / 3.0) * state.hub_displacement * slope_of_stiffness / (1.0 + stiffening_ * b);
    return {-climbing_ * normal_load * rise_per_metre - resistance_ * b, 0.0, 0.0};
  }

 private:
  double bump(double x) const {
    const double u = (x - position_) / half_width_;
    return std::exp(-0.5 * u * u);
  }

  double position_;
  double half_width_;
  double stiffening_;
  double climbing_;
  double resistance_;
};

}  // namespace

EffectType buried_rock() {
  return {"buried_rock",
          Place::soil,
          {{"position", "m", -0.1, 3.0, 0.5, shape_parameter},
           {"half_width", "m", 0.004, 0.5, 0.05, shape_parameter},
           {"stiffening", "fraction", 0.0, 30.0, 1.0, 0.0},
           {"climbing", "fraction", 0.0, 1.0, 1.0, 1.0},
           {"resistance", "N", 0.0, 100.0, 3.0, 0.0}},
          "Sieve the bed where the report shows the hub rising.",
          "Narrow in distance: eccentricity and soft spokes come back with every turn of the wheel.",
          construct<BuriedRock>};
}

}  // namespace wheel_twin::effects
