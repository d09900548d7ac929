#include "effects/catalogue.h"

#include <fmt/format.h>

#include "base/error.h"

namespace wheel_twin::effects {

const std::vector<EffectType>& catalogue() {
  static const std::vector<EffectType> effects = {
      ft_bias(),
      ft_drift(),
      ft_thermal(),
      ft_misalignment(),
      ft_gain(),
      ft_crosstalk(),
      draw_wire_offset(),
      draw_wire_scale(),
      draw_wire_jump(),
      draw_wire_drift(),
      clock_skew(),
      carriage_speed_error(),
      dead_weight_error(),
      slide_friction(),
      rig_compliance(),
      bed_tilt(),
      steering_misalignment(),
      motor_drag(),
      wheel_eccentricity(),
      soft_spoke(),
      wheel_flexing_resistance(),
      slip_sinkage(),
      slip_loosening(),
      bulldozing(),
      soil_cohesion(),
      density_gradient(),
      multi_pass(),
      hard_layer(),
      buried_rock(),
  };
  return effects;
}

const EffectType& find_effect(const std::string& name) {
  std::string names;
  for (const EffectType& type : catalogue()) {
    if (type.name == name) return type;
    names += (names.empty() ? "" : ", ") + type.name;
  }
  throw Error(fmt::format("effect {}: not in the catalogue; known are {}", name, names));
}

}  // namespace wheel_twin::effects
