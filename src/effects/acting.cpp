#include "effects/acting.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

double number_of(const std::string& text, const EffectType& type, const Parameter& parameter) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw Error(fmt::format("effect {}: {} is not a number: '{}'", type.name, parameter.name, text));
  return value;
}

std::unique_ptr<Effect> read_effect(const EffectType& type, const std::string& parameters) {
  std::vector<double> values;
  for (const Parameter& parameter : type.parameters) values.push_back(parameter.neutral);
  std::istringstream list(parameters);
  for (std::string item; std::getline(list, item, ',');) {
    const std::size_t equals = item.find('=');
    const std::string name = item.substr(0, equals);
    std::size_t index = 0;
    while (index < type.parameters.size() && type.parameters[index].name != name) ++index;
    if (index == type.parameters.size())
      throw Error(fmt::format("effect {}: it has no parameter '{}'", type.name, name));
    values[index] =
        number_of(equals == std::string::npos ? "" : item.substr(equals + 1), type, type.parameters[index]);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i]))
      throw Error(fmt::format("effect {}: {} must be given", type.name, type.parameters[i].name));
  }
  return make_effect(type, values);
}

}  // namespace

void Acting::add(std::unique_ptr<Effect> effect) {
  effect->attach(ports);
  effects.push_back(std::move(effect));
}

Acting read_effects(const std::vector<std::string>& texts,
                    const std::function<void(const rig::Ports&)>& check) {
  Acting acting;
  for (const std::string& text : texts) {
    const std::size_t colon = text.find(':');
    const EffectType& type = find_effect(text.substr(0, colon));
    std::unique_ptr<Effect> effect =
        read_effect(type, colon == std::string::npos ? "" : text.substr(colon + 1));
    if (check) {
      rig::Ports own;
      effect->attach(own);
      try {
        check(own);
      } catch (const Error& error) {
        throw Error(fmt::format("effect {}: {}", type.name, error.what()));
      }
    }
    acting.add(std::move(effect));
  }
  return acting;
}

}  // namespace wheel_twin::effects
