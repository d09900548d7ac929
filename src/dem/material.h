// Bulk and pairwise properties of what touches: soil, wheel, walls. The bulk properties are those of an
// isotropic elastic solid; restitution, friction and the properties of the further laws belong to a pair of
// materials (paper, Section 3 and Table 2). SI units.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace wheel_twin::dem {

struct Material {
  std::string name;
  double density = 0.0;         ///< kg/m^3
  double shear_modulus = 0.0;   ///< Pa
  double poisson_ratio = 0.25;  ///< in (-1, 0.5)

  double youngs_modulus() const { return 2.0 * shear_modulus * (1.0 + poisson_ratio); }
};

struct PairProperties {
  double restitution = 0.5;              ///< in (0, 1]
  double friction = 0.5;                 ///< static coefficient, at least 0
  double rolling_friction = 0.0;         ///< coefficient of rolling resistance; 0 switches the law off
  double cohesion_energy_density = 0.0;  ///< J/m^3 of the simplified JKR law; 0 switches it off
};

/// Materials and the properties of every pair. Pairs that nobody set keep the defaults above.
class MaterialTable {
 public:
  /// Returns the index of the new material. Throws Error naming the material when a value is out of range.
  std::uint32_t add(const Material& material);
  /// Order of the two does not matter. Throws Error naming both when a value is out of range.
  void set_pair(std::uint32_t a, std::uint32_t b, const PairProperties& properties);

  std::size_t size() const { return materials_.size(); }
  const Material& operator[](std::uint32_t index) const { return materials_.at(index); }
  const PairProperties& pair(std::uint32_t a, std::uint32_t b) const { return pairs_.at(a).at(b); }
  bool rolling() const;   ///< any pair with rolling friction
  bool cohesive() const;  ///< any pair with cohesion

 private:
  std::vector<Material> materials_;
  std::vector<std::vector<PairProperties>> pairs_;
};

/// Time in which a shear wave crosses a sphere of `radius` (m), paper Eq. 4, s.
double rayleigh_time(const Material& material, double radius);

}  // namespace wheel_twin::dem
