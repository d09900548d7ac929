// Settled beds for benchmarks: spheres or four-sphere clumps in a periodic box over a floor, grain sizes and
// properties as in Table 2 of the paper. SI units.
#pragma once

#include <functional>
#include <string>

#include "dem/granular_soil.h"
#include "dem/system.h"

namespace wheel_twin::dem {

struct ReferenceBed {
  bool clumps = true;           ///< the clumps of `soil`, else single spheres of 2.7 to 3.3 mm
  std::size_t spheres = 80000;  ///< at least this many
  double time_step = 1.77e-5;   ///< s
  int threads = 1;
  SleepSettings sleep;
};

/// The world without particles.
System make_reference_world(const ReferenceBed& bed, const GranularSoil& soil);

/// Fills the world and lets it settle under gravity. `progress` is told the fraction done. The bed is at rest
/// when a particle moves slower than 1 mm/s in the mean square.
void settle_reference_bed(System& system, const ReferenceBed& bed, const GranularSoil& soil,
                          const std::function<void(double)>& progress);

/// `settled` laid side by side, `across_x` times `across_y` copies in a world so much larger: a settled bed
/// of any size, contacts across the seams included.
System tiled_reference_bed(const System& settled, const ReferenceBed& bed, const GranularSoil& soil,
                           int across_x, int across_y);

/// The spheres as a data file of LAMMPS (atom style hybrid sphere molecular; a clump is a molecule).
std::string lammps_data(const System& system);

}  // namespace wheel_twin::dem
