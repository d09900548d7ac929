// Contact laws. The base is Hertz-Mindlin with Tsuji damping and a Coulomb limit (paper, Section 3); two
// further laws may be added to it: elastic-plastic rolling resistance (Ai et al. 2011, type C; stiffness of
// Wensrich and Katterfeld 2012) and cohesion by contact area (simplified JKR, Kloss et al. 2012). A law
// declares the properties of a pair of materials that it needs and the history that a contact carries;
// contact_law-inl.h evaluates it.
//
// With overlap d, equivalent radius R, modulus E, shear modulus G and mass m:
//   F_n = 4/3 E sqrt(R) d^1.5,  S_n = 2 E sqrt(R d),  F_n^d = -2 sqrt(5/6) |beta| sqrt(S_n m) v_n,
//   F_t = -S_t xi,              S_t = 8 G sqrt(R d),  F_t^d = -2 sqrt(5/6) |beta| sqrt(S_t m) v_t,  |F_t +
//   F_t^d| <= mu F_n
// The spring xi is turned with the normal (and with the pair's spin about it). As the normal force falls, F_t
// falls with S_t; as it grows, F_t is kept and xi shortened, so that a change of overlap never makes energy.
// While the contact slides, spring and damper together carry mu F_n: the damper sees the velocity of the
// spring, not of the slip.
#pragma once

#include <vector>

#include "dem/material.h"
#include "dem/store.h"

namespace wheel_twin::dem {

/// What a contact carries from step to step: arrays of PairList beyond the spring and the overlap.
struct ContactLaw {
  bool rolling = false;   ///< needs rolling_friction; history: rolling spring (3)
  bool cohesive = false;  ///< needs cohesion_energy_density; no history
};
ContactLaw law_of(const MaterialTable& materials);

/// Index of a pair of materials in the law table.
inline std::uint32_t law_index(std::uint32_t a, std::uint32_t b) {
  return a > b ? a * (a + 1) / 2 + b : b * (b + 1) / 2 + a;
}

LawTable make_law_table(const MaterialTable& materials);

/// Tsuji's damping: 2 sqrt(5/6) |beta| for a coefficient of restitution.
double tsuji_damping(double restitution);

/// Pairwise stiffness and damping, computed when a pair enters the list.
class PairCoefficients {
 public:
  explicit PairCoefficients(const MaterialTable& materials);
  /// k_n of F_n = k_n d^1.5. A wall has radius 0 for "flat". `stiffness`: factors on the moduli.
  float normal_stiffness(std::uint32_t material_a, double stiffness_a, double radius_a,
                         std::uint32_t material_b, double stiffness_b, double radius_b) const;
  /// c of F_n^d = -c sqrt(S_n) v_n. A wall has no inverse mass.
  float damping(std::uint32_t material_a, double inverse_mass_a, std::uint32_t material_b,
                double inverse_mass_b) const;

 private:
  std::vector<double> compliance_;  ///< (1 - nu^2) / E
  std::vector<double> tsuji_;       ///< by law_index
};

}  // namespace wheel_twin::dem
