// Small worlds for the tests of the granular engine: the soil of Table 2 (four-sphere column) and spheres of
// 3 mm.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/random.h"
#include "dem/system.h"

namespace wheel_twin::dem::test {

constexpr double kRadius = 3e-3;  // m, nominal

inline Material soil() {
  return {"soil", 2759.0, 3e7, 0.25};
}
inline Material steel() {
  return {"wall", 7800.0, 8.023e10, 0.29};
}

inline MaterialTable table(double restitution = 0.5, double friction = 0.9, double wall_friction = 0.5) {
  MaterialTable materials;
  const auto s = materials.add(soil());
  const auto w = materials.add(steel());
  PairProperties pair;
  pair.restitution = restitution;
  pair.friction = friction;
  materials.set_pair(s, s, pair);
  pair.friction = wall_friction;
  materials.set_pair(s, w, pair);
  return materials;
}

inline ClumpTemplate ball(double radius = kRadius) {
  return make_clump("sphere", {{Eigen::Vector3d::Zero(), radius}});
}

/// A lopsided clump of three spheres: three different principal moments.
inline ClumpTemplate lopsided() {
  return make_clump("lopsided", {{{0.0, 0.0, 0.0}, kRadius},
                                 {{1.2 * kRadius, 0.0, 0.0}, 0.8 * kRadius},
                                 {{0.3 * kRadius, 0.9 * kRadius, 0.2 * kRadius}, 0.6 * kRadius}});
}

/// Four equal spheres on a compact tetrahedron.
inline ClumpTemplate four() {
  const double c = 0.45 * kRadius;
  return make_clump("four", {{{c, c, c}, 0.8 * kRadius},
                             {{c, -c, -c}, 0.8 * kRadius},
                             {{-c, c, -c}, 0.8 * kRadius},
                             {{-c, -c, c}, 0.8 * kRadius}});
}

inline WorldSettings empty_space(double side = 0.2) {
  WorldSettings settings;
  settings.low.setConstant(-side);
  settings.high.setConstant(side);
  settings.gravity.setZero();
  settings.time_step = 1e-6;
  return settings;
}

/// A column of 60 x 60 mm, periodic, over a floor at z = 0, that keeps the energy book.
inline WorldSettings booked_column() {
  WorldSettings settings;
  settings.low = {0.0, 0.0, -0.01};
  settings.high = {0.06, 0.06, 0.2};
  settings.periodic_x = settings.periodic_y = true;
  settings.time_step = 5e-6;
  settings.smallest_size = 0.9;
  settings.track_energy = true;
  return settings;
}

/// What the energy book holds less what walls put in.
inline double total(const EnergyBook& book) {
  return book.kinetic + book.potential + book.elastic + book.damped + book.friction - book.wall_work;
}

/// The message of the error that `action` ends with, or "accepted".
inline std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

inline Particle at(const Eigen::Vector3d& position,
                   const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) {
  Particle p;
  p.position = position;
  p.velocity = velocity;
  return p;
}

inline Wall floor_wall(double z = 0.0) {
  Wall wall;
  wall.name = "floor";
  wall.material = 1;
  wall.shape = HalfSpace{};
  wall.pose.position.z() = z;
  return wall;
}

/// `n` particles with random places on a lattice, directions and sizes, above z = 0 in a periodic box.
inline std::vector<Particle> cloud(int nx, int ny, int nz, double spacing, std::uint32_t shapes,
                                   std::uint64_t seed, double speed = 0.1) {
  Random random(seed);
  std::vector<Particle> particles;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        Particle p;
        p.shape = static_cast<std::uint32_t>(particles.size()) % shapes;
        p.size = random.uniform(0.9, 1.1);
        p.position = spacing * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.8);
        p.orientation = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
                            .normalized();
        for (int a = 0; a < 3; ++a) {
          p.velocity[a] = speed * random.normal();
          p.angular_velocity[a] = 100.0 * speed * random.normal();
        }
        particles.push_back(p);
      }
    }
  }
  return particles;
}

/// A periodic box over a floor, for clouds of nx x ny lattice sites.
inline System box_of(int nx, int ny, double height, double spacing, const std::vector<ClumpTemplate>& shapes,
                     int threads = 1, const MaterialTable& materials = table()) {
  WorldSettings settings;
  settings.low = {0.0, 0.0, -0.01};
  settings.high = {nx * spacing, ny * spacing, height};
  settings.periodic_x = settings.periodic_y = true;
  settings.time_step = 1.77e-5;
  settings.smallest_size = 0.9;
  settings.threads = threads;
  System system(settings, materials, shapes);
  system.add_wall(floor_wall());
  return system;
}

}  // namespace wheel_twin::dem::test
