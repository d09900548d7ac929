#include "terramechanics/wheel.h"

namespace wheel_twin::terramechanics {

Wheel read_wheel(const yaml::Map& map) {
  Wheel wheel;
  wheel.name = map.text_or("name", wheel.name);
  wheel.radius = map.number("radius", {0.005, 5.0});
  wheel.width = map.number("width", {0.001, 5.0});
  wheel.grousers = static_cast<int>(map.integer_or("grousers", 0, 0, 10000));
  wheel.grouser_height = map.number_or("grouser_height", 0.0, {0.0, 1.0});
  wheel.stiffness = map.optional_number("stiffness", yaml::positive());
  wheel.flexing_resistance = map.number_or("flexing_resistance", 0.0, yaml::non_negative());
  map.skip("multibody");
  map.finish();
  return wheel;
}

}  // namespace wheel_twin::terramechanics
