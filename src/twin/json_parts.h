// What several of the JSON outputs have in common. SI units.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "twin/channel_error.h"

namespace wheel_twin::twin {

/// null where `value` is not finite.
nlohmann::ordered_json number_json(double value);

/// By channel: unit, before, after, noise_floor.
nlohmann::ordered_json errors_json(const Errors& errors);

}  // namespace wheel_twin::twin
