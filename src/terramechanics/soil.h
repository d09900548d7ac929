// Semi-empirical soil parameters (paper, Section 2): Bekker pressure-sinkage, Mohr-Coulomb, Janosi-Hanamoto.
#pragma once

#include <string>

#include "base/yaml.h"

namespace wheel_twin::terramechanics {

struct Soil {
  std::string name = "soil";
  double k_c = 1370.0;      ///< cohesive modulus of deformation, N/m^(n+1)
  double k_phi = 814000.0;  ///< frictional modulus of deformation, N/m^(n+2)
  double n = 1.0;           ///< sinkage exponent
  double c = 0.0;           ///< cohesion, Pa
  double phi = 0.6981317;   ///< angle of internal friction, rad
  double K = 0.022;         ///< shear deformation modulus, m
  double c1 = 0.4;          ///< theta_m = (c1 + c2 s) theta_1
  double c2 = 0.15;
  double gamma = 0.3;               ///< exit angle coefficient: theta_2 from gamma z
  double weight_density = 13000.0;  ///< gamma_s, N/m^3
};

/// Keys as the members; missing weight_density takes the default; others are required. Refuses unknown keys.
Soil read_soil(const yaml::Map& map);

}  // namespace wheel_twin::terramechanics
