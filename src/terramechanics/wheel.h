// What the semi-empirical contact knows of a wheel.
#pragma once

#include <optional>
#include <string>

#include "base/yaml.h"

namespace wheel_twin::terramechanics {

struct Wheel {
  std::string name = "wheel";
  double radius = 0.09;             ///< m, rim without grousers
  double width = 0.07;              ///< m
  int grousers = 0;                 ///< count around the rim
  double grouser_height = 0.0;      ///< m
  std::optional<double> stiffness;  ///< hub load over hub deflection on hard ground, N/m; none: rigid
  double flexing_resistance = 0.0;  ///< R_f of the paper, N off the drawbar pull while rolling
};

/// Keys as the members, `stiffness: null` for a rigid wheel. The key `multibody` belongs to the flexible
/// wheel and is skipped. Refuses unknown keys.
Wheel read_wheel(const yaml::Map& map);

}  // namespace wheel_twin::terramechanics
