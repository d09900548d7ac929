// The grains of a discrete-element soil as a picture shows them. SI units.
#pragma once

#include <vector>

#include "cosim/dem_soil.h"
#include "dem/system.h"

namespace wheel_twin::cosim {

struct SphereMotion {
  double speed = 0.0;  ///< of the centre, m/s
  double force = 0.0;  ///< of all contacts on its clump, N
};
/// In the order of `system.spheres()`.
std::vector<SphereMotion> sphere_motions(const dem::System& system);

/// In the same order and in rig axes, each sphere by as many lengths of a periodic bed along it as bring it
/// next to rig position `x`, m.
std::vector<dem::SphereState> spheres_about(const DemSoil& soil, double x);

}  // namespace wheel_twin::cosim
