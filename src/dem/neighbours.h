// Pairs of spheres that may touch soon. The outer list comes from a grid of cells as large as the largest
// small sphere and its skin; spheres much larger than the mean (rocks) are kept out of the grid and look into
// it. Every body has its own skin: what it may move before the list must be made anew, so a few fast
// particles do not cost the resting ones.
#pragma once

#include <cstdint>
#include <vector>

#include "dem/kernels.h"
#include "dem/store.h"

namespace wheel_twin::dem {

/// Pairs by the thread that works on them: class t holds pairs inside the bodies of thread t, the last class
/// pairs of bodies of two threads.
struct OuterList {
  std::vector<std::vector<std::uint32_t>> i, j;  ///< sphere numbers
};

/// Bodies of thread t: [bounds[t], bounds[t + 1]).
using ThreadBounds = std::vector<std::size_t>;

/// All pairs of spheres of different bodies whose surfaces are nearer than the sum of the bodies' reserves;
/// pairs inside class `without` (sleeping bodies) are left out, and those of sleeping bodies far from awake
/// ones.
void find_pairs(const Bodies& bodies, const Spheres& spheres, const Period& period,
                const ThreadBounds& bounds, OuterList& list, std::size_t without = ~std::size_t{0});

/// Order of the bodies in space: cells along the longest side of the bed first; sleeping bodies behind the
/// others.
std::vector<std::uint32_t> spatial_order(const Bodies& bodies, const Period& period, double cell);

/// Rearranges bodies and spheres.
void permute(Bodies& bodies, Spheres& spheres, const ShapeTable& shapes,
             const std::vector<std::uint32_t>& order);

}  // namespace wheel_twin::dem
