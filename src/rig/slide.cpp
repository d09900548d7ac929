#include "rig/slide.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace wheel_twin::rig {

SlideVelocity slide_velocity(const SlideForces& forces, double mass, double velocity, double dt,
                             std::optional<double> lowest_velocity) {
  const double drive = mass * velocity / dt + forces.soil - forces.weight;
  const double resistance = mass / dt + forces.damping + std::max(0.0, forces.stiffness) * dt;
  SlideVelocity result;
  result.friction = -std::clamp(drive, -forces.coulomb, forces.coulomb);
  result.velocity = (drive + result.friction) / resistance;
  if (lowest_velocity && result.velocity < *lowest_velocity) {
    result.velocity = *lowest_velocity;
    result.held = true;
  }
  return result;
}

SlideEquilibrium slide_equilibrium(const std::function<HubLoad(double)>& soil_at, double height,
                                   double weight, double coulomb, double lowest) {
  constexpr int most_evaluations = 100;
  const double tolerance = 1e-6 * weight;
  SlideEquilibrium state;
  state.height = height;
  state.load = soil_at(height);
  const double unbalance = state.load.force_hub_rig.z() - weight;
  state.friction = -std::clamp(unbalance, -coulomb, coulomb);

  double too_low = -std::numeric_limits<double>::infinity();  // the soil carries too much here
  double too_high = std::numeric_limits<double>::infinity();  // and too little here
  double previous_height = height;
  double previous_rest = 0.0;
  for (int evaluations = 1;; ++evaluations) {
    const double rest = state.load.force_hub_rig.z() - weight + state.friction;  // upward force left over
    if (!std::isfinite(rest))
      throw Error(fmt::format("the soil's force is {} at hub height {} m", rest, state.height));
    if (std::abs(rest) <= tolerance) return state;
    (rest > 0.0 ? too_low : too_high) = state.height;
    if (too_high <= lowest)
      throw Error(fmt::format("no equilibrium: a hub {:.0f} mm down meets {:.3g} N, the load is {:.3g} N",
                              -1e3 * state.height, state.load.force_hub_rig.z(), weight));
    if (evaluations >= most_evaluations || too_high - too_low < 1e-12)
      throw Error(fmt::format(
          "no equilibrium under {:.6g} N: the soil's force jumps by {:.3g} N at hub height {:.6g} m", weight,
          std::abs(rest), state.height));

    double stiffness = state.load.vertical_stiffness;
    if (evaluations > 1 && state.height != previous_height) {
      const double secant = -(rest - previous_rest) / (state.height - previous_height);
      if (secant > 0.0 && std::isfinite(secant)) stiffness = secant;
    }
    constexpr double longest_move = 0.005;  // m
    double next =
        state.height + std::clamp(rest / std::max(stiffness, 1e-9 * weight), -longest_move, longest_move);
    next = std::max(next, lowest);
    if (next <= too_low || next >= too_high) next = 0.5 * (too_low + too_high);
    previous_height = state.height;
    previous_rest = rest;
    state.height = next;
    state.load = soil_at(next);
  }
}

}  // namespace wheel_twin::rig
