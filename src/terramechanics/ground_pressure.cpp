#include "terramechanics/ground_pressure.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.h"

namespace wheel_twin::terramechanics {

double sinkage_modulus(const Wheel& wheel, const Soil& soil) {
  const double k_eq = soil.k_c / wheel.width + soil.k_phi;
  if (!(k_eq > 0.0)) {
    throw Error(fmt::format("soil '{}': k_c / b + k_phi = {:g} is not positive for a wheel {:g} m wide",
                            soil.name, k_eq, wheel.width));
  }
  return k_eq;
}

double critical_ground_pressure(const Wheel& wheel, const Soil& soil, double load) {
  const double n = soil.n;
  const double spread = 3.0 * load / ((3.0 - n) * wheel.width * std::sqrt(2.0 * wheel.radius));
  return std::pow(sinkage_modulus(wheel, soil), 1.0 / (2.0 * n + 1.0)) *
         std::pow(spread, 2.0 * n / (2.0 * n + 1.0));
}

double flat_patch_length(double radius, double deflection) {
  return 2.0 * std::sqrt(deflection * (2.0 * radius - deflection));
}

double hard_ground_pressure(const Wheel& wheel, double load) {
  if (!wheel.stiffness) return std::numeric_limits<double>::infinity();
  const double delta_d = load / *wheel.stiffness;
  if (!(delta_d < wheel.radius)) {
    throw Error(fmt::format("wheel '{}': a load of {:g} N deflects it by {:g} m, beyond its radius",
                            wheel.name, load, delta_d));
  }
  if (delta_d == 0.0) return 0.0;
  return load / (wheel.width * flat_patch_length(wheel.radius, delta_d));
}

bool works_as_flexible(const Wheel& wheel, const Soil& soil, double load) {
  return wheel.stiffness && hard_ground_pressure(wheel, load) < critical_ground_pressure(wheel, soil, load);
}

}  // namespace wheel_twin::terramechanics
