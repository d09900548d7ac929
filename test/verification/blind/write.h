// A drawn experiment as files: OUT/NAME with experiment.yaml and bags, and OUT/truth/NAME.yaml.
#pragma once

#include <cstdint>
#include <string>

#include "draw.h"

namespace wheel_twin::blind {

/// `seed` makes what is random in the runs. Throws Error when a run cannot be simulated or written.
void write(const Drawn& drawn, const std::string& name, const std::string& out, std::uint64_t seed);

}  // namespace wheel_twin::blind
