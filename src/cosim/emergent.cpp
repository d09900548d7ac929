#include "cosim/emergent.h"

#include "base/error.h"

namespace wheel_twin::cosim {

void refuse_what_emerges(const std::vector<const rig::SoilPort*>& ports) {
  for (const double slip : {0.5, -0.5}) {
    rig::RigState state;
    state.slip = slip;
    state.rim_travel = 1.0;
    state.carriage_speed = 0.01;
    state.hub_displacement = 0.01;
    rig::RigState rolling = state;
    rolling.slip = 0.0;
    for (const rig::SoilPort* port : ports) {
      if (port->sinkage_factor(state) != 1.0 ||
          port->stiffness_factor(state) != port->stiffness_factor(rolling) ||
          port->added_force(state, 40.0) != port->added_force(rolling, 40.0))
        throw Error(
            "fidelity dem: an effect makes soil answer to the wheel's slip, which grains do by themselves: "
            "leave it out");
    }
  }
}

void refuse_what_emerges(const std::vector<const rig::WheelPort*>& ports) {
  rig::RigState rolling;
  rolling.wheel_rate = 1.0;
  for (const rig::WheelPort* port : ports) {
    if (port->rolling_resistance(rolling) != 0.0)
      throw Error(
          "fidelity dem: a flexing resistance of the wheel comes out of its dampers: leave the effect out");
  }
}

}  // namespace wheel_twin::cosim
