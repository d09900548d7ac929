// What grains and a flexible wheel do by themselves: an effect of that kind on top would count it twice.
#pragma once

#include <vector>

#include "rig/ports.h"

namespace wheel_twin::cosim {

/// Throws Error when soil answers to the wheel's slip, or sinkage is scaled.
void refuse_what_emerges(const std::vector<const rig::SoilPort*>& ports);
/// Throws Error when the wheel resists flexing.
void refuse_what_emerges(const std::vector<const rig::WheelPort*>& ports);

}  // namespace wheel_twin::cosim
