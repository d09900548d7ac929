#include "effects/effect.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"

namespace wheel_twin::effects {

std::unique_ptr<Effect> make_effect(const EffectType& type, const std::vector<double>& values) {
  if (values.size() != type.parameters.size())
    throw Error(fmt::format("effect {}: {} parameters are expected, not {}", type.name,
                            type.parameters.size(), values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& parameter = type.parameters[i];
    if (!std::isfinite(values[i]) || values[i] < parameter.lower || values[i] > parameter.upper)
      throw Error(fmt::format("effect {}: {} = {} {} is outside {} to {}", type.name, parameter.name,
                              values[i], parameter.unit, parameter.lower, parameter.upper));
  }
  return type.make(values);
}

}  // namespace wheel_twin::effects
