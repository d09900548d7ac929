#include "dem/limits.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

// While a bed is made: its cloud, the engine (175 bytes a sphere in clumps, 392 single: twin bench) and a
// state of it.
constexpr double bytes_per_clump = 300.0;
constexpr double bytes_per_sphere = 150.0;

/// Bytes that this process may still take; infinite where the system does not say.
double free_memory() {
  double free = std::numeric_limits<double>::infinity();
  std::ifstream in("/proc/meminfo");
  std::string key;
  double kilobytes = 0.0;
  for (std::string unit; in >> key >> kilobytes; std::getline(in, unit)) {
    if (key == "MemAvailable:") free = 1024.0 * kilobytes;
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    free = std::min(free, static_cast<double>(limit.rlim_cur));
  return free;
}

}  // namespace

void check_positive(const std::string& what, double value, double largest) {
  if (value > 0.0 && value <= largest && std::isfinite(value)) return;
  throw Error(largest < 1e300
                  ? fmt::format("{} is {}: above 0 and at most {} is wanted", what, value, largest)
                  : fmt::format("{} is {}: a number above 0 is wanted", what, value));
}

void check_memory(const std::string& what, double clumps, double spheres) {
  const double needed = bytes_per_clump * clumps + bytes_per_sphere * spheres;
  const double free = free_memory();
  if (needed <= free) return;
  throw Error(
      fmt::format("{}: {:.3g} clumps of {:.3g} spheres need at least {:.3g} GB of memory, {:.3g} GB are free",
                  what, clumps, spheres, 1e-9 * needed, 1e-9 * free));
}

void check_bed(const GranularSoil& soil, const BedSettings& s) {
  check_positive("bed: length (m)", s.length);
  check_positive("bed: width (m)", s.width);
  check_positive("bed: depth (m)", s.depth);
  check_positive("bed: gravity (m/s^2)", s.gravity);
  check_positive("bed: packing density of the cloud", s.cloud_density, 0.5);
  if (s.fill_friction && !(*s.fill_friction >= 0.0 && std::isfinite(*s.fill_friction)))
    throw Error(fmt::format("bed: friction while filling is {}", *s.fill_friction));
  const double clumps = soil.packing_density * s.length * s.width * s.depth / soil.clumps.mean_volume();
  check_memory(fmt::format("bed of {} x {} x {} m", s.length, s.width, s.depth), clumps,
               soil.clumps.mean_spheres() * clumps);
}

}  // namespace wheel_twin::dem
