// An effect: something that acts on soil, wheel, rig or sensors and that the baseline twin lacks. The class
// that simulates it through the ports of rig/ports.h is the class whose parameters a diagnosis fits. Names
// and parameters are the interface of twin files and diagnoses; units are SI.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "rig/ports.h"

namespace wheel_twin::effects {

/// One parameter: `lower` to `upper` is what is physically possible, `scale` the size at which a rig engineer
/// would care (the standard deviation of the prior about `neutral`), `neutral` the value at which the effect
/// vanishes. Shape parameters (a phase, a length, a position) do not make the effect vanish: their neutral is
/// NaN.
struct Parameter {
  std::string name;
  std::string unit;
  double lower = 0.0;
  double upper = 0.0;
  double scale = 1.0;
  double neutral = 0.0;
  bool periodic = false;  ///< upper wraps to lower (an angle)
};

inline constexpr double shape_parameter = std::numeric_limits<double>::quiet_NaN();

/// An effect with its parameters set. Stays alive while it is attached.
class Effect {
 public:
  virtual ~Effect() = default;
  /// Adds itself to the ports that it implements.
  virtual void attach(rig::Ports& ports) const = 0;
};

enum class Place { sensor, log, rig, wheel, soil };

struct EffectType {
  std::string name;
  Place place = Place::sensor;
  std::vector<Parameter> parameters;
  std::string advice;           ///< what a rig engineer checks when this effect is found
  std::string identifiability;  ///< what it is easily confused with, and what separates them
  /// Values in the order of `parameters`. Values out of bounds or not finite are refused by make_effect.
  std::unique_ptr<Effect> (*make)(const std::vector<double>& values) = nullptr;
};

/// Checks count and bounds. Throws Error naming effect and parameter.
std::unique_ptr<Effect> make_effect(const EffectType& type, const std::vector<double>& values);

/// A common factory: Type is an aggregate constructible from the vector of values.
template <typename Type>
std::unique_ptr<Effect> construct(const std::vector<double>& values) {
  return std::make_unique<Type>(values);
}

}  // namespace wheel_twin::effects
