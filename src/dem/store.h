// How the engine keeps bodies, spheres and contacts in memory. Bodies lie in the order of space (cells along
// x, y, z), a body's spheres lie together. A sphere's row is what a contact reads and fills one cache line;
// its centre is *defined* as the body's centre plus a lever in single precision, so that levers and centres
// agree exactly and angular momentum is kept to round-off. Rows and loads are read and written whole (64
// bytes).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace wheel_twin::dem {

/// Memory on cache lines; large blocks on pages of 2 MB, where the system has them. Freed by release().
void* take(std::size_t bytes);
void release(void* block, std::size_t bytes);

/// Memory on cache lines.
template <typename T>
struct CacheAligned {
  using value_type = T;
  CacheAligned() = default;
  template <typename U>
  CacheAligned(const CacheAligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(take(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { release(p, n * sizeof(T)); }
  template <typename U>
  bool operator==(const CacheAligned<U>&) const {
    return true;
  }
  template <typename U>
  bool operator!=(const CacheAligned<U>&) const {
    return false;
  }
};
template <typename T>
using Column = std::vector<T, CacheAligned<T>>;

constexpr std::size_t kBatch = 8;  ///< bodies and contacts are worked on in batches of this many

struct alignas(64) SphereRow {
  double x[3];     ///< centre, m
  float v[3];      ///< velocity of the body's centre, m/s
  float w[3];      ///< angular velocity, rad/s
  float lever[3];  ///< from the body's centre to the sphere's, m
  float radius;    ///< m
};
static_assert(sizeof(SphereRow) == 64);

/// Sum of the contacts of a body.
struct alignas(64) LoadRow {
  double force[3];   ///< N
  double torque[3];  ///< about the centre of mass, N m
  double pressure;   ///< sum of the normal forces' magnitudes, N
  double unused;
};
static_assert(sizeof(LoadRow) == 64);

struct Bodies {
  std::size_t count = 0;  ///< the arrays are longer: padded to a batch, and one batch of dummies behind
  Column<double> x[3];    ///< centre of mass, m
  Column<double> v[3];    ///< at half steps, m/s
  Column<double> l[3];    ///< angular momentum at half steps, world axes, kg m^2/s
  Column<double> q[4];    ///< orientation w, x, y, z; empty when every template is one sphere
  Column<double> inverse_mass;
  Column<double> inverse_inertia[3];  ///< principal; only the first when every template is one sphere
  Column<float> size;                 ///< factor on the template
  Column<float> stiffness;            ///< factor on the moduli
  Column<float> slack;  ///< way that a sphere of the body may still go before the inner list must be made, m
  Column<float> reserve;        ///< further way before the outer list must be made, m
  Column<float> reach;          ///< largest lever, m
  Column<std::uint32_t> rank;   ///< number of the particle
  Column<std::uint32_t> first;  ///< first sphere
  Column<std::uint16_t> shape, material;
  Column<std::uint8_t> asleep;
  Column<LoadRow> load;
};

struct Spheres {
  std::size_t count = 0;  ///< two dummies behind, far apart from everything, stand in for missing pairs
  Column<SphereRow> row;
  Column<std::uint32_t> body;
};

/// Contact candidates of the inner list, one structure of arrays; what `columns` holds travels with the pair.
struct PairList {
  static constexpr int kStiffness = 0;  ///< normal stiffness k_n: F_n = k_n overlap^1.5, N/m^1.5
  static constexpr int kDamping = 1;    ///< c_d: damping coefficient over the root of the stiffness, kg^0.5
  static constexpr int kShear = 2;      ///< 3 columns, tangential spring, m
  static constexpr int kOverlap = 5;    ///< at the last step, m; 0: not touching
  static constexpr int kRolling = 6;    ///< 3 columns, only with rolling friction
  static constexpr int kColumns = 9;

  std::size_t size = 0;  ///< a multiple of kBatch
  Column<std::uint32_t> i, j;
  Column<std::uint32_t> source;  ///< place in the outer list, increasing
  Column<std::uint8_t> law;      ///< pair of materials; empty when there is only one
  std::array<Column<float>, kColumns> columns;
};

/// Properties of a pair of materials as the contact law wants them.
struct LawTable {
  Column<float> shear_ratio;  ///< S_t / S_n = 4 G_eq / E_eq
  Column<float> shear_ratio_root;
  Column<float> friction;
  Column<float> rolling;
  Column<float> cohesion;  ///< J/m^3
};

}  // namespace wheel_twin::dem
