// What is measured on a packing: density by layers, coordination, surface, floor pressure. Packing density is
// the volume inside grains (the union of a clump's spheres, overlap once) over the bulk volume. SI units, z
// up.
#pragma once

#include <vector>

#include "dem/system.h"

namespace wheel_twin::dem {

struct Box {
  Eigen::Vector3d low{0.0, 0.0, 0.0};
  Eigen::Vector3d high{0.0, 0.0, 0.0};
};

/// Packing density of the horizontal layers of `region`, the lowest first, each `thickness` thick (the last
/// one may be thinner by rounding the number of layers). Each clump counts by 128 points spread evenly over
/// its union.
std::vector<double> layer_densities(const System& system, const Box& region, double thickness);

/// Packing density of the whole region.
double packing_density(const System& system, const Box& region);

/// Upper envelope of the spheres on a grid of points: NaN where no sphere is above the point.
struct HeightMap {
  double x = 0.0, y = 0.0;     ///< of the first point, m
  double spacing = 0.0;        ///< m
  int columns = 0, rows = 0;   ///< along x and y
  std::vector<double> height;  ///< m, row by row
  double at(int column, int row) const { return height[static_cast<std::size_t>(row) * columns + column]; }
};
HeightMap height_map(const std::vector<SphereState>& spheres, const Box& region, double spacing);
/// Mean of the points that have a height, m. NaN when there is none.
double mean_height(const HeightMap& map);

struct Coordination {
  double per_clump = 0.0;   ///< mean number of other clumps that a clump touches
  double per_sphere = 0.0;  ///< mean number of contacts of a sphere with other clumps
};
/// Over the clumps whose centre lies inside the region.
Coordination coordination(const System& system, const Box& region);

}  // namespace wheel_twin::dem
