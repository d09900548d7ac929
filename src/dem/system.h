// The granular world: rigid clumps of spheres under gravity that touch one another and walls. Leapfrog for
// the centres, a symplectic splitting for the rotations (see rotation.h), Hertz-Mindlin contacts
// (contact_law.h). Results do not depend on the number of threads, the neighbour lists or a restart:
// contributions to a body's force are rounded to one common quantum, so that their sum is exact in any order.
// SI units, world frame, z usually up.
//
// Particles are numbered 0, 1, 2... in the order in which they were added; remove() closes the gaps and keeps
// the order.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dem/clump_template.h"
#include "dem/material.h"
#include "dem/walls.h"

namespace wheel_twin::dem {

/// Parts of a bed at rest cost next to nothing: see system_sleep.cpp for the rule.
struct SleepSettings {
  bool enabled = false;
  /// m/s; a particle is quiet when its centre has not moved faster, on the mean of half of `time`. 0: nothing
  /// falls asleep but what hold_beyond() puts to sleep.
  double speed = 2e-4;
  /// A sleeper wakes when its unbalanced force passes this fraction of what presses on it.
  double force = 0.3;
  double time = 0.04;        ///< s that every particle of a cell must be quiet before the cell falls asleep
  double wake_factor = 3.0;  ///< a cell wakes beside a particle that is faster than `speed` by this factor
};

struct WorldSettings {
  Eigen::Vector3d low{0.0, 0.0, 0.0};  ///< domain, m. A particle outside a non-periodic side is an error
  Eigen::Vector3d high{1.0, 1.0, 1.0};
  bool periodic_x = false;
  bool periodic_y = false;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< m/s^2
  double time_step = 0.0;                    ///< s; 0: step_fraction times the smallest Rayleigh time
  double step_fraction = 0.2;  ///< of the Rayleigh time (paper, Eq. 4); a step of more than 0.5 is refused
  double smallest_size =
      1.0;  ///< smallest size factor to come, for the Rayleigh time; add() refuses smaller ones
  std::uint32_t particle_materials = 1;  ///< materials 0 to this minus 1 may be those of particles
  int threads = 1;
  SleepSettings sleep;
  bool track_energy = false;            ///< keeps the energy book; slower
  double largest_start_overlap = 0.05;  ///< of the smaller radius; a deeper overlap in add() is an error
};

/// One body. Velocities are those of the full step, world axes.
struct Particle {
  std::uint32_t shape = 0;  ///< index of the clump template
  double size = 1.0;        ///< factor on the template; rounded to single precision
  std::uint32_t material = 0;
  double stiffness = 1.0;  ///< factor on the shear modulus: local changes of stiffness along x or with depth
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< centre of mass, m; inside the domain on periodic axes
  Eigen::Quaterniond orientation =
      Eigen::Quaterniond::Identity();               ///< body to world; stays constant for one sphere
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};          ///< m/s
  Eigen::Vector3d angular_velocity{0.0, 0.0, 0.0};  ///< rad/s
};

/// One sphere of a body, for export and measures.
struct SphereState {
  Eigen::Vector3d center{0.0, 0.0,
                         0.0};  ///< m; may stick out of the periodic domain with its body's centre inside
  double radius = 0.0;
  std::uint32_t particle = 0;
};

/// A contact that carries a tangential spring. `a` < `b` are sphere numbers (spheres of particle 0, of
/// particle 1, ...) or, for walls, sphere and wall.
struct ContactHistory {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t facet = 0;         ///< walls: face of the part that was touched last
  float overlap = 0.0F;            ///< m, at the last step
  std::array<float, 3> shear{};    ///< tangential spring of a relative to b, m, world axes
  std::array<float, 3> rolling{};  ///< rolling spring, rad
};

/// A touching pair of spheres, for measures (coordination number, force chains, stress).
struct ContactForce {
  std::uint32_t sphere_a = 0;
  std::uint32_t sphere_b = 0;
  Eigen::Vector3d point{0.0, 0.0, 0.0};       ///< m
  Eigen::Vector3d force_on_a{0.0, 0.0, 0.0};  ///< N
  double overlap = 0.0;                       ///< m
};

/// Everything that decides the future of a system with the same settings, materials and templates: restoring
/// it continues with identical bits.
struct State {
  std::int64_t step = 0;
  std::vector<std::uint32_t> shape, material;  ///< per particle
  std::vector<float> size, stiffness;
  std::vector<Eigen::Vector3d> position, velocity, angular_momentum;  ///< velocity, momentum at half steps
  std::vector<Eigen::Vector4d> orientation;                           ///< w, x, y, z
  std::vector<Eigen::Matrix<double, 7, 1>>
      load;  ///< contact force, torque, sum of normal forces at the last step
  std::vector<ContactHistory> contacts, wall_contacts;
  std::vector<Wall> walls;
  std::vector<std::uint8_t> wall_removed;
  std::vector<std::uint8_t> asleep;  ///< per particle; empty: all awake
  std::vector<std::uint32_t> quiet;  ///< per cell of the sleeping rule
  std::vector<Eigen::Vector3d>
      looked_at;             ///< per particle: where it was at the last look of the sleeping rule
  std::vector<double> hold;  ///< middle and half length of hold_beyond(), m; empty: nothing is held
};

/// Energy book, J. Kept from the start of the run when `track_energy`; kinetic and potential always.
/// kinetic + potential + elastic + damped + friction - wall_work is constant.
struct EnergyBook {
  double kinetic = 0.0;    ///< translation and rotation
  double potential = 0.0;  ///< gravity, zero at the world's origin
  double elastic = 0.0;    ///< normal, tangential and rolling springs
  double damped = 0.0;     ///< viscous loss in the normal direction, since the start
  double friction =
      0.0;  ///< lost in the tangential direction (sliding, viscous, on unloading), since the start
  double wall_work = 0.0;  ///< work of moving walls on the particles since the start
};

/// What a run has cost; wall-clock seconds since the system was made.
struct Statistics {
  std::int64_t steps = 0;
  std::int64_t list_builds = 0;     ///< of the outer neighbour list
  std::int64_t list_refreshes = 0;  ///< of the inner list
  std::size_t candidates = 0;       ///< pairs in the inner list now
  std::size_t contacts = 0;         ///< touching pairs of spheres at the last step, sleeping ones left out
  std::size_t sleeping = 0;         ///< particles asleep
  std::size_t memory_bytes = 0;     ///< held for particles, lists and histories
  double seconds_contacts = 0.0, seconds_walls = 0.0, seconds_motion = 0.0, seconds_lists = 0.0;
  double bytes_per_step = 0.0;  ///< least traffic of a step: every array touched, counted once
};

class System {
 public:
  /// Throws Error when a setting is out of range or the step is too large for a material and template.
  System(const WorldSettings& settings, const MaterialTable& materials, std::vector<ClumpTemplate> templates);
  ~System();
  System(System&&) noexcept;
  System& operator=(System&&) noexcept;

  /// Appends particles. Throws Error naming the particle when one is not finite, outside the domain, of an
  /// unknown template or material, or overlaps another particle or a wall deeper than allowed; nothing is
  /// added then.
  void add(const std::vector<Particle>& particles);
  /// Removes the particles whose entry is true; one entry a particle.
  void remove(const std::vector<bool>& which);

  /// Returns the number of the wall. Throws Error when a shape is degenerate.
  std::uint32_t add_wall(const Wall& wall);
  void remove_wall(std::uint32_t wall);  ///< numbers of the others stay
  /// From the next step on the wall moves with this velocity.
  void set_wall_motion(std::uint32_t wall, const Motion& motion);
  /// The wall is here at the next evaluation of forces and moves on from there with `motion`.
  void set_wall_pose(std::uint32_t wall, const Pose& pose, const Motion& motion);
  /// Another geometry for the part (a rim segment that bends). Same kind of shape, same number of faces.
  void set_wall_shape(std::uint32_t wall, const Mesh& mesh);
  const Wall& wall(std::uint32_t wall) const;
  /// Force and torque of the particles on the wall in the last step.
  Wrench wall_wrench(std::uint32_t wall) const;
  std::size_t wall_count() const;  ///< removed ones included

  /// Advances by `count` steps. Throws Error naming step and particle when something is not finite, leaves
  /// the domain or overlaps beyond all reason; the system is then no longer fit for use.
  void step(int count = 1);

  std::int64_t step_number() const;
  double time() const;  ///< step number times step, s
  double time_step() const;
  double rayleigh_step() const;  ///< smallest Rayleigh time of the materials and templates, s
  const WorldSettings& settings() const;
  const MaterialTable& materials() const;
  const std::vector<ClumpTemplate>& templates() const;

  /// A window that moves: from the next step on particles farther than `half_length` from `middle` along x
  /// (around the period) are held where they are, those nearer than that move. Cells of the sleeping rule
  /// change as a whole, and only when `middle` has moved by half of one. Throws Error unless sleep is
  /// enabled.
  void hold_beyond(double middle, double half_length);

  /// Changes that take effect at the next step.
  void set_pair(std::uint32_t material_a, std::uint32_t material_b, const PairProperties& properties);
  void set_gravity(const Eigen::Vector3d& gravity);
  void set_threads(int threads);
  void stop_all();  ///< sets every velocity to zero

  std::size_t size() const;  ///< particles
  std::size_t sphere_count() const;
  std::vector<Particle> particles() const;
  Particle particle(std::size_t index) const;
  double mass(std::size_t index) const;  ///< kg
  void set_velocity(std::size_t index, const Eigen::Vector3d& velocity,
                    const Eigen::Vector3d& angular_velocity);
  std::vector<SphereState> spheres() const;
  /// Contact force and torque (about the centre of mass) on each particle in the last step, without gravity.
  std::vector<Wrench> loads() const;
  std::vector<ContactForce> contacts() const;  ///< of the present positions

  EnergyBook energy() const;
  Statistics statistics() const;

  State state() const;
  /// Replaces all particles, contacts and walls. Throws Error when the state does not fit templates or
  /// materials.
  void restore(const State& state);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::dem
