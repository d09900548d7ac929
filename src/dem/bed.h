// Settled soil beds. A cloud of clumps falls under gravity with a friction that gives the wanted packing
// density (found on a small column of the same depth), the friction is restored, the surface is levelled and
// the bed settles again (paper, Section 6.2). Frame of the bed: x from 0 along travel, y to the left from the
// middle, z up with 0 at the mean surface and the floor at -depth. SI units.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dem/granular_soil.h"
#include "dem/measures.h"
#include "dem/system.h"

namespace wheel_twin::dem {

struct BedSettings {
  double length = 0.48;    ///< x, m
  double width = 0.22;     ///< y, m
  double depth = 0.10;     ///< m
  bool periodic_x = true;  ///< else walls
  bool periodic_y = true;
  double gravity = 9.81;  ///< m/s^2
  std::uint64_t seed = 1;
  double cloud_density = 0.24;  ///< packing density of the cloud; smaller: a taller fall
  /// Grain to grain while filling; what goes beyond the grains' own friction resists
  /// rolling (a looser bed than friction alone gives). Nothing: tuned to the packing density.
  std::optional<double> fill_friction;
};

struct BedReport {
  std::size_t clumps = 0, spheres = 0;
  double fill_friction = 0.0;
  double packing_density = 0.0;       ///< between floor and surface, `margin` away from both
  double margin = 0.0;                ///< m
  double layer_thickness = 0.0;       ///< m
  std::vector<double> layer_density;  ///< the lowest layer first, from the floor to the surface
  double kinetic_energy = 0.0;        ///< J
  double weight = 0.0;                ///< N
  double floor_force = 0.0;           ///< N, of the soil on the floor, positive down
  Coordination coordination;          ///< away from floor and surface
  double simulated_time = 0.0;        ///< s, tuning not included
};

struct Bed {
  BedSettings settings;
  BedReport report;
  State state;
};

/// Everything that determines a bed, as a text.
std::string bed_description(const GranularSoil& soil, const BedSettings& settings);

/// An empty system with the floor (wall 0) and, where the bed is not periodic, its side walls. `headroom`:
/// height of the domain above the surface, m.
System bed_world(const GranularSoil& soil, const BedSettings& settings, double headroom, int threads,
                 const SleepSettings& sleep = {});

/// Fetches the bed from the cache, or makes it: minutes for a bed of 30,000 clumps, with a checkpoint every
/// minute from which a killed run goes on. Throws Error naming what was out of reach.
Bed fetch_bed(const GranularSoil& soil, const BedSettings& settings, int threads = 1);

/// The same from scratch, without the cache.
Bed make_bed(const GranularSoil& soil, const BedSettings& settings, int threads = 1,
             const std::string& checkpoint_path = "");

/// A bed ready to step: bed_world with the bed's particles, contacts and walls.
System bed_system(const GranularSoil& soil, const Bed& bed, double headroom, int threads,
                  const SleepSettings& sleep = {});

void write_bed(const std::string& path, const Bed& bed, const std::string& description);
Bed read_bed(const std::string& path);

}  // namespace wheel_twin::dem
