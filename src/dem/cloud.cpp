#include "dem/cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/error.h"
#include "dem/limits.h"

namespace wheel_twin::dem {
namespace {

struct Ball {
  Eigen::Vector3d center;
  double radius;
};

// Spheres in cubic cells of the largest diameter; periodic sides wrap.
class Grid {
 public:
  Grid(const CloudRegion& region, double cell) : low_(region.low) {
    const Eigen::Vector3d size = region.high - region.low;
    for (int k = 0; k < 3; ++k) {
      count_[k] = std::max<long>(1, static_cast<long>(size[k] / cell));
      width_[k] = size[k] / count_[k];
      periodic_[k] = (k == 0 && region.periodic_x) || (k == 1 && region.periodic_y);
      length_[k] = size[k];
    }
    cells_.resize(count_[0] * count_[1] * count_[2]);
  }

  void wrap(Eigen::Vector3d& x) const {
    for (int k = 0; k < 3; ++k)
      if (periodic_[k]) x[k] -= length_[k] * std::floor((x[k] - low_[k]) / length_[k]);
  }

  bool is_free(const Ball& ball) const {
    long at[3];
    locate(ball.center, at);
    for (long i = -1; i <= 1; ++i)
      for (long j = -1; j <= 1; ++j)
        for (long k = -1; k <= 1; ++k) {
          const long neighbour[3] = {at[0] + i, at[1] + j, at[2] + k};
          const long cell = index(neighbour);
          if (cell < 0) continue;
          for (const Ball& other : cells_[cell]) {
            Eigen::Vector3d d = other.center - ball.center;
            for (int a = 0; a < 3; ++a)
              if (periodic_[a]) d[a] -= length_[a] * std::round(d[a] / length_[a]);
            const double reach = other.radius + ball.radius;
            if (d.squaredNorm() < reach * reach) return false;
          }
        }
    return true;
  }

  void insert(const Ball& ball) {
    long at[3];
    locate(ball.center, at);
    cells_[index(at)].push_back(ball);
  }

 private:
  void locate(const Eigen::Vector3d& x, long at[3]) const {
    for (int k = 0; k < 3; ++k)
      at[k] = std::clamp(static_cast<long>((x[k] - low_[k]) / width_[k]), 0L, count_[k] - 1);
  }
  long index(const long at[3]) const {
    long cell = 0;
    for (int k = 0; k < 3; ++k) {
      long i = at[k];
      if (periodic_[k])
        i = (i + count_[k]) % count_[k];
      else if (i < 0 || i >= count_[k])
        return -1;
      cell = cell * count_[k] + i;
    }
    return cell;
  }

  Eigen::Vector3d low_;
  double width_[3], length_[3];
  long count_[3];
  bool periodic_[3];
  std::vector<std::vector<Ball>> cells_;
};

Eigen::Quaterniond random_orientation(Random& random) {
  const double w = random.normal();
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return Eigen::Quaterniond(w, x, y, z).normalized();
}

// Shape numbers in shuffled order, each shape as often as its share says (largest remainders rounded up).
std::vector<std::uint32_t> shuffled_shapes(const ClumpFamily& family, std::size_t count, Random& random) {
  std::vector<std::uint32_t> shapes;
  double sum = 0.0;
  for (std::size_t i = 0; i < family.shares.size(); ++i) {
    sum += family.shares[i];
    const auto end =
        i + 1 == family.shares.size() ? count : static_cast<std::size_t>(std::llround(sum * count));
    while (shapes.size() < end) shapes.push_back(static_cast<std::uint32_t>(i));
  }
  for (std::size_t i = shapes.size(); i > 1; --i)
    std::swap(shapes[i - 1], shapes[static_cast<std::size_t>(random.uniform() * static_cast<double>(i))]);
  return shapes;
}

}  // namespace

std::vector<Particle> random_cloud(const ClumpFamily& family, const CloudRegion& region, std::size_t count,
                                   Random& random, std::uint32_t material) {
  const auto clumps = static_cast<double>(count);
  check_memory("random cloud", clumps, clumps * family.mean_spheres());
  double largest_radius = 0.0;
  for (const ClumpTemplate& shape : family.shapes)
    for (const ClumpSphere& sphere : shape.spheres) largest_radius = std::max(largest_radius, sphere.radius);
  Grid grid(region, 2.0 * largest_radius * family.largest_size);
  constexpr int attempts = 20000;
  std::vector<Particle> cloud;
  cloud.reserve(count);
  std::vector<Ball> balls;
  for (const std::uint32_t shape : shuffled_shapes(family, count, random)) {
    const double size = static_cast<float>(random.uniform(family.smallest_size, family.largest_size));
    bool placed = false;
    for (int attempt = 0; attempt < attempts && !placed; ++attempt) {
      Particle particle;
      particle.shape = shape;
      particle.size = size;
      particle.material = material;
      for (int k = 0; k < 3; ++k) particle.position[k] = random.uniform(region.low[k], region.high[k]);
      particle.orientation = random_orientation(random);
      balls.clear();
      placed = true;
      for (const ClumpSphere& sphere : family.shapes[shape].spheres) {
        Ball ball{particle.position + particle.orientation * (size * sphere.center), size * sphere.radius};
        for (int k = 0; k < 3 && placed; ++k) {
          if ((k == 0 && region.periodic_x) || (k == 1 && region.periodic_y)) continue;
          placed =
              ball.center[k] - ball.radius >= region.low[k] && ball.center[k] + ball.radius <= region.high[k];
        }
        placed = placed && (!region.admits || region.admits(ball.center, ball.radius));
        if (!placed) break;
        grid.wrap(ball.center);
        placed = grid.is_free(ball);
        if (!placed) break;
        balls.push_back(ball);
      }
      if (!placed) continue;
      for (const Ball& ball : balls) grid.insert(ball);
      cloud.push_back(particle);
    }
    if (!placed)
      throw Error(fmt::format("random cloud: no room for clump {} of {}: the region is too small",
                              cloud.size() + 1, count));
  }
  return cloud;
}

}  // namespace wheel_twin::dem
