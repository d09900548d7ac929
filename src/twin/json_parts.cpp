#include "twin/json_parts.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace wheel_twin::twin {

using Json = nlohmann::ordered_json;

Json number_json(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json errors_json(const Errors& errors) {
  Json json = Json::object();
  for (const auto& [channel, error] : errors)
    json[std::string(name_of(channel))] = {{"unit", unit_of(channel)},
                                           {"before", number_json(error.before)},
                                           {"after", number_json(error.after)},
                                           {"noise_floor", number_json(error.noise_floor)}};
  return json;
}

}  // namespace wheel_twin::twin
