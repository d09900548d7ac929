// The same packing in LAMMPS: writes data and input files (rigid/small clumps with the mass properties of the
// union, pair granular with hertz/material, mindlin_rescale and Tsuji damping), runs `lmp` and reads back
// what is compared.
#pragma once

#include <string>
#include <vector>

#include "dem/bed.h"

namespace wheel_twin::dem::lammps {

struct Setup {
  Eigen::Vector3d low, high;  ///< domain, periodic in x and y, floor at `floor`
  double floor = 0.0;
  double gravity = 9.81;
  double friction = 0.5;  ///< grain to grain
  double time_step = 0.0;
  long steps = 0;
};

/// Writes `folder`/in.lammps, data.lammps and bodies.lammps.
void write(const std::string& folder, const GranularSoil& soil, const std::vector<Particle>& particles,
           const Setup& setup);

struct Result {
  std::vector<SphereState> spheres;  ///< at the end
  double floor_force = 0.0;          ///< N, positive down
  double kinetic_energy = 0.0;       ///< J, translation of the spheres as LAMMPS computes it
  double contacts = 0.0;             ///< touching pairs of spheres of different clumps
};

/// Runs `lmp` in the folder on one thread. Throws Error with the folder's name when it fails.
Result run(const std::string& folder);

}  // namespace wheel_twin::dem::lammps
