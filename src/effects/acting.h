// Effects that act together, and how a user names them: "slide_friction:coulomb_force=3.5",
// "ft_drift:rate_x=0.01,rate_z=-0.02".
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "effects/effect.h"
#include "rig/ports.h"

namespace wheel_twin::effects {

/// Effects at the ports of a rig, as long as this lives.
struct Acting {
  std::vector<std::unique_ptr<Effect>> effects;
  rig::Ports ports;

  void add(std::unique_ptr<Effect> effect);
};

/// Each text "name:parameter=value,..."; a parameter that is not named stays neutral, one of shape must be
/// named. `check` is given the ports of every effect by itself. Throws Error naming the effect and the
/// parameter, also where `check` throws.
Acting read_effects(const std::vector<std::string>& texts,
                    const std::function<void(const rig::Ports&)>& check = {});

}  // namespace wheel_twin::effects
