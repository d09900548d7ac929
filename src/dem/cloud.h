// A cloud of clumps that do not touch: random sequential insertion at random orientation, checked sphere by
// sphere. The start of every settled packing.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "base/random.h"
#include "dem/clump_template.h"
#include "dem/system.h"

namespace wheel_twin::dem {

struct CloudRegion {
  Eigen::Vector3d low{0.0, 0.0, 0.0};  ///< m
  Eigen::Vector3d high{0.0, 0.0, 0.0};
  bool periodic_x = false;  ///< else spheres stay inside
  bool periodic_y = false;
  /// A further limit on every sphere (centre, radius): true when it may be there.
  std::function<bool(const Eigen::Vector3d&, double)> admits;
};

/// Shapes by their shares (in equal parts: as equal as the count allows), sizes uniform. Throws Error when
/// the region is too small for the count: random insertion ends near a third of the volume.
std::vector<Particle> random_cloud(const ClumpFamily& family, const CloudRegion& region, std::size_t count,
                                   Random& random, std::uint32_t material);

}  // namespace wheel_twin::dem
