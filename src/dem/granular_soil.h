// A soil as the discrete-element engine sees it: clump family, elastic and frictional properties of the
// grains and of the walls around them (paper, Table 2). The `dem:` section of a soil file. SI units.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/yaml.h"
#include "dem/clump_template.h"
#include "dem/material.h"

namespace wheel_twin::dem {

struct GranularSoil {
  std::string name = "soil";
  ClumpFamily clumps;
  Material grain{"soil", 2759.0, 3.0e7, 0.25};
  Material wall{"wall", 7800.0, 8.023e10, 0.29};
  PairProperties grain_grain{0.5, 0.9, 0.0, 0.0};
  PairProperties grain_wall{0.5, 0.5, 0.0, 0.0};
  double packing_density = 0.52;       ///< of a settled bed: volume inside grains over bulk volume
  double shear_box_void_ratio = 0.89;  ///< of the sample in a direct shear test: pores over grains
  double step_fraction = 0.2;          ///< of the Rayleigh time step (paper, Eq. 4)

  /// Material 0 are the grains, material 1 the walls.
  static constexpr std::uint32_t grain_material = 0;
  static constexpr std::uint32_t wall_material = 1;
  MaterialTable materials() const;

  /// Every number above in one text, digits enough for the same bits: part of the name of a cached bed.
  std::string fingerprint() const;
};

/// Keys of the section: clumps (name of a file in config/clumps, or a path), density, shear_modulus,
/// poisson_ratio, restitution, friction, rolling_friction (default 0), cohesion_energy_density (default 0),
/// packing_density, shear_box_void_ratio, step_fraction, wall: {density, shear_modulus, poisson_ratio,
/// restitution, friction}.
GranularSoil read_granular_soil(const yaml::Map& section);

/// The `dem:` section of a soil file. `name` is a file in config/soils or a path. Throws Error when there is
/// none.
GranularSoil load_granular_soil(const std::string& name);

}  // namespace wheel_twin::dem
