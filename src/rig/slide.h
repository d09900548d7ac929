// The vertical guide: one degree of freedom under the soil's force, dead weight, viscous and Coulomb
// friction. Dynamic steps are linearly implicit in the contact's stiffness (first order, L-stable), so that a
// step of 1 ms holds on stiff ground; Coulomb friction sticks exactly. Heights are positive up, m; forces N.
#pragma once

#include <functional>
#include <optional>

#include "rig/contact.h"

namespace wheel_twin::rig {

struct SlideForces {
  double soil = 0.0;       ///< vertical force of the soil on the hub, positive up
  double stiffness = 0.0;  ///< -d(soil)/d(height), N/m
  double weight = 0.0;     ///< dead weight, positive down
  double damping = 0.0;    ///< N s/m
  double coulomb = 0.0;    ///< at least 0
};

struct SlideVelocity {
  double velocity = 0.0;  ///< at the end of the step, m/s, positive up
  double friction = 0.0;  ///< Coulomb friction on the slide, N, positive up
  bool held = false;      ///< the hoist's rope is taut
};

/// Velocity after a step of dt: m (v1 - v0)/dt = soil - stiffness dt v1 - weight - damping v1 + friction,
/// with |friction| <= coulomb against the motion; not below `lowest_velocity` where a rope holds.
SlideVelocity slide_velocity(const SlideForces& forces, double mass, double velocity, double dt,
                             std::optional<double> lowest_velocity);

struct SlideEquilibrium {
  double height = 0.0;    ///< m
  double friction = 0.0;  ///< N, positive up
  HubLoad load;           ///< at that height
};

/// Height at which soil, weight and Coulomb friction balance, nearest to where the slide stands: it stays
/// while friction can hold it, and else moves until friction alone is left to oppose. `soil_at` gives the
/// load at a height. Throws Error when no height down to `lowest` carries the weight.
SlideEquilibrium slide_equilibrium(const std::function<HubLoad(double)>& soil_at, double height,
                                   double weight, double coulomb, double lowest);

}  // namespace wheel_twin::rig
