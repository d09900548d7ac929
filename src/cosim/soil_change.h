// What the soil ports of a rig mean to a discrete-element bed, applied once to a settled bed:
// - a factor f(x, depth) on the pressure-sinkage law: unit weight and moduli of the grains times f. A
//   cohesionless soil whose grains have f times the density and f times the modulus carries f times the
//   pressure at the same sinkage (every force scales, every overlap and the Rayleigh time stay), so that a
//   uniform factor is met exactly and the settled bed stays in equilibrium. A factor that varies comes in 18
//   geometric steps; above 50 it counts as 50. On a periodic bed it is laid from 50 mm behind the start of
//   the run, half of a wheel's contact, to one length of the bed further on.
// - an added cohesion c: an attraction between grains in contact (contact_law.h), whose strength is found
//   from Rumpf's formula, sigma_t = packing density * contacts a grain * F / (pi d^2), sigma_t = c /
//   tan(phi).
// - a slope of the surface: the bed and its gravity are turned against the rig.
// SI units.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "dem/bed.h"
#include "dem/granular_soil.h"
#include "rig/ports.h"

namespace wheel_twin::cosim {

/// A bed's grains and materials with the changes that ports ask for.
struct ChangedBed {
  dem::MaterialTable materials;
  std::uint32_t grain_materials = 1;  ///< the first ones; the next one is the walls'
  dem::State state;
  bool changed = false;
  double slope = 0.0;  ///< of the surface along x, rad
  /// Rig position up to which the bed is what was asked for; beyond it a periodic bed comes round, m.
  double good_until = std::numeric_limits<double>::infinity();
};

/// `start_x`: place in the bed at which the run begins, m. Throws Error when a port asks for what the
/// discrete-element soil has by itself (`sinkage_factor`), or for a factor out of range.
ChangedBed change_bed(const dem::GranularSoil& soil, const dem::Bed& bed, double start_x,
                      const std::vector<const rig::SoilPort*>& ports);

}  // namespace wheel_twin::cosim
