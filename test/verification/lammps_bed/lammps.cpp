#include "lammps.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "base/error.h"

namespace wheel_twin::dem::lammps {

void write(const std::string& folder, const GranularSoil& soil, const std::vector<Particle>& particles,
           const Setup& setup) {
  std::string atoms;
  std::string molecules;
  std::string bodies = fmt::format("{}\n", particles.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Particle& p = particles[i];
    const ClumpTemplate& shape = soil.clumps.shapes[p.shape];
    const Eigen::Matrix3d turn = p.orientation.toRotationMatrix();
    const double mass = soil.grain.density * shape.volume * std::pow(p.size, 3);
    const Eigen::Matrix3d inertia =
        soil.grain.density * std::pow(p.size, 5) * (turn * shape.inertia.asDiagonal() * turn.transpose());
    for (const ClumpSphere& sphere : shape.spheres) {
      Eigen::Vector3d x = p.position + turn * (p.size * sphere.center);
      Eigen::Vector3i image = Eigen::Vector3i::Zero();
      for (int k = 0; k < 2; ++k) {
        const double length = setup.high[k] - setup.low[k];
        image[k] = static_cast<int>(std::floor((x[k] - setup.low[k]) / length));
        x[k] -= image[k] * length;
      }
      ++count;
      atoms += fmt::format("{} 1 {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {} {} {}\n", count,
                           2.0 * p.size * sphere.radius, soil.grain.density, x.x(), x.y(), x.z(), image.x(),
                           image.y(), image.z());
      molecules += fmt::format("{} {}\n", count, i + 1);
    }
    // A body of one sphere needs rigid/small too, so that all clumps move alike.
    const Eigen::Vector3d& x = p.position;
    bodies += fmt::format(
        "{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} 0 0 0 0 0 0 0 0 "
        "0\n",
        i + 1, mass, x.x(), x.y(), x.z(), inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1),
        inertia(0, 2), inertia(1, 2));
  }
  const auto save = [&](const char* name, const std::string& text) {
    std::ofstream out(folder + "/" + name);
    out << text;
    out.close();
    if (!out) throw Error(fmt::format("{}/{}: cannot be written", folder, name));
  };
  save("data.lammps",
       fmt::format(
           "settled bed\n\n{} atoms\n1 atom types\n\n{:.17g} {:.17g} xlo xhi\n{:.17g} {:.17g} ylo yhi\n"
           "{:.17g} {:.17g} zlo zhi\n\nAtoms # sphere\n\n{}\nMolecules\n\n{}",
           count, setup.low.x(), setup.high.x(), setup.low.y(), setup.high.y(), setup.low.z(), setup.high.z(),
           atoms, molecules));
  save("bodies.lammps", bodies);
  const double nu = soil.grain.poisson_ratio;
  const double young = soil.grain.youngs_modulus();
  // LAMMPS takes both bodies of a contact with the wall to be of one material: the material whose effective
  // moduli are those of the pair (normal), and the tangential stiffness given outright.
  const double wall_effective =
      1.0 / ((1.0 - nu * nu) / young +
             (1.0 - soil.wall.poisson_ratio * soil.wall.poisson_ratio) / soil.wall.youngs_modulus());
  const double wall_shear = 1.0 / ((2.0 - nu) / soil.grain.shear_modulus +
                                   (2.0 - soil.wall.poisson_ratio) / soil.wall.shear_modulus);
  save("in.lammps",
       fmt::format(
           R"(units si
atom_style sphere
atom_modify map array
boundary p p f
comm_modify vel yes cutoff {cutoff}
newton off
fix body all property/atom mol ghost yes
read_data data.lammps fix body NULL Molecules
neighbor 0.001 bin
neigh_modify delay 0 every 1 check yes
neigh_modify exclude molecule/intra all
pair_style granular
pair_coeff * * hertz/material {young:.17g} {restitution} {nu} tangential mindlin_rescale NULL 1.0 {friction} damping tsuji
timestep {step:.17g}
fix move all rigid/small molecule infile bodies.lammps gravity weight
fix weight all gravity {gravity} vector 0 0 -1 disable
fix floor all wall/gran granular hertz/material {wall_young:.17g} {wall_restitution} {nu} tangential mindlin_rescale {wall_kt:.17g} 1.0 {wall_friction} damping tsuji zplane {floor:.17g} NULL contacts
compute floor_fz all reduce sum f_floor[4]
compute touching all contact/atom
compute contacts all reduce sum c_touching
compute ke all ke/rigid move
thermo_style custom step time c_ke c_floor_fz c_contacts
thermo_modify format float %.10g
thermo {every}
run {steps}
write_dump all custom final.lammps id mol radius xu yu z modify sort id format float %.17g
)",
           fmt::arg("cutoff", 4.0 * soil.clumps.largest_bounding_radius()), fmt::arg("young", young),
           fmt::arg("restitution", soil.grain_grain.restitution), fmt::arg("nu", nu),
           fmt::arg("friction", setup.friction), fmt::arg("step", setup.time_step),
           fmt::arg("gravity", setup.gravity), fmt::arg("wall_young", wall_effective * 2.0 * (1.0 - nu * nu)),
           fmt::arg("wall_restitution", soil.grain_wall.restitution), fmt::arg("wall_kt", 8.0 * wall_shear),
           fmt::arg("wall_friction", soil.grain_wall.friction), fmt::arg("floor", setup.floor),
           fmt::arg("every", std::max(1L, setup.steps / 40)), fmt::arg("steps", setup.steps)));
}

Result run(const std::string& folder) {
  const std::string command =
      fmt::format("cd '{}' && OMP_NUM_THREADS=1 lmp -in in.lammps -log log.lammps > out.lammps 2>&1", folder);
  if (std::system(command.c_str()) != 0)  // NOLINT(cert-env33-c,concurrency-mt-unsafe): the peer is a program
    throw Error(fmt::format("{}: lmp failed: see out.lammps there", folder));
  Result result;
  std::ifstream log(folder + "/log.lammps");
  for (std::string line; std::getline(log, line);) {
    std::istringstream words(line);
    double step, time, kinetic, floor, contacts;
    if (words >> step >> time >> kinetic >> floor >> contacts) {
      result.kinetic_energy = kinetic;
      result.floor_force = floor;
      result.contacts = 0.5 * contacts;
    }
  }
  std::ifstream dump(folder + "/final.lammps");
  std::string line;
  while (std::getline(dump, line) && line.rfind("ITEM: ATOMS", 0) != 0) {
  }
  double id, body;
  SphereState sphere;
  while (dump >> id >> body >> sphere.radius >> sphere.center.x() >> sphere.center.y() >> sphere.center.z()) {
    sphere.particle = static_cast<std::uint32_t>(body - 1);
    result.spheres.push_back(sphere);
  }
  return result;
}

}  // namespace wheel_twin::dem::lammps
