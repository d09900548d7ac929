#include "dem/contact_law.h"

#include <cmath>

namespace wheel_twin::dem {

ContactLaw law_of(const MaterialTable& materials) {
  return {materials.rolling(), materials.cohesive()};
}

double tsuji_damping(double restitution) {
  const double log_e = std::log(restitution);
  const double beta = -log_e / std::sqrt(log_e * log_e + M_PI * M_PI);
  return 2.0 * std::sqrt(5.0 / 6.0) * beta;
}

LawTable make_law_table(const MaterialTable& materials) {
  LawTable table;
  for (std::uint32_t a = 0; a < materials.size(); ++a) {
    for (std::uint32_t b = 0; b <= a; ++b) {
      const Material& p = materials[a];
      const Material& q = materials[b];
      const double e_eq = 1.0 / ((1.0 - p.poisson_ratio * p.poisson_ratio) / p.youngs_modulus() +
                                 (1.0 - q.poisson_ratio * q.poisson_ratio) / q.youngs_modulus());
      const double g_eq =
          1.0 / ((2.0 - p.poisson_ratio) / p.shear_modulus + (2.0 - q.poisson_ratio) / q.shear_modulus);
      const double ratio = 4.0 * g_eq / e_eq;
      const PairProperties& pair = materials.pair(a, b);
      table.shear_ratio.push_back(static_cast<float>(ratio));
      table.shear_ratio_root.push_back(static_cast<float>(std::sqrt(ratio)));
      table.friction.push_back(static_cast<float>(pair.friction));
      table.rolling.push_back(static_cast<float>(pair.rolling_friction));
      table.cohesion.push_back(static_cast<float>(pair.cohesion_energy_density));
    }
  }
  return table;
}

PairCoefficients::PairCoefficients(const MaterialTable& materials) {
  for (std::uint32_t a = 0; a < materials.size(); ++a) {
    const Material& p = materials[a];
    compliance_.push_back((1.0 - p.poisson_ratio * p.poisson_ratio) / p.youngs_modulus());
    for (std::uint32_t b = 0; b <= a; ++b) tsuji_.push_back(tsuji_damping(materials.pair(a, b).restitution));
  }
}

float PairCoefficients::normal_stiffness(std::uint32_t material_a, double stiffness_a, double radius_a,
                                         std::uint32_t material_b, double stiffness_b,
                                         double radius_b) const {
  const double e_eq = 1.0 / (compliance_[material_a] / stiffness_a + compliance_[material_b] / stiffness_b);
  const double r_eq = radius_b > 0.0 ? radius_a * radius_b / (radius_a + radius_b) : radius_a;
  return static_cast<float>(4.0 / 3.0 * e_eq * std::sqrt(r_eq));
}

float PairCoefficients::damping(std::uint32_t material_a, double inverse_mass_a, std::uint32_t material_b,
                                double inverse_mass_b) const {
  return static_cast<float>(tsuji_[law_index(material_a, material_b)] /
                            std::sqrt(inverse_mass_a + inverse_mass_b));
}

}  // namespace wheel_twin::dem
