// The inside of System, shared by the files that implement it.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <unordered_map>
#include <vector>

#include "dem/contact_law.h"
#include "dem/kernels.h"
#include "dem/neighbours.h"
#include "dem/store.h"
#include "dem/system.h"
#include "dem/thread_team.h"
#include "dem/wall_set.h"

namespace wheel_twin::dem {

/// Seconds since construction or the last lap.
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Energy that contacts lose, from the work of their forces by the trapezoidal rule over the leapfrog's
/// steps.
class LossBook {
 public:
  /// What a contact did in the last step: the part of the force that is not conservative, and its stored
  /// energy.
  struct Entry {
    Eigen::Vector3d tangential{0.0, 0.0, 0.0};
    Eigen::Vector3d moment{0.0, 0.0, 0.0};  ///< that resists rolling
    double damping = 0.0;
    double stored = 0.0;  ///< in the tangential and the rolling spring, J
    std::int64_t step = -1;
  };
  /// `sign`: -1 when the trace is that of the second of the pair relative to the first.
  void record(std::uint64_t key, const float* trace, std::size_t stride, double sign, double stored,
              double time_step, std::int64_t step);
  void forget_old(std::int64_t step);
  /// The contact sleeps: it stays in the book.
  void keep(std::uint64_t key, std::int64_t step);
  /// The contact has fallen asleep: nothing moves, and from here on it exerts what `trace` says.
  void put_to_rest(std::uint64_t key, const float* trace, std::size_t stride, double sign);
  double damped = 0.0;
  double friction = 0.0;
  double wall_work = 0.0;
  double crossings = 0.0;  ///< potential energy that leaving one side and entering the other would change, J

 private:
  std::unordered_map<std::uint64_t, Entry> entries_;
};

struct System::Impl {
  Impl(const WorldSettings& settings_in, const MaterialTable& materials_in,
       std::vector<ClumpTemplate> templates_in);

  // system_build.cpp
  void append(const std::vector<Particle>& particles);
  void check_new(const std::vector<Particle>& particles) const;
  void check_overlaps(std::size_t first_new);
  void erase(const std::vector<bool>& which);
  void resize(std::size_t bodies_count, std::size_t sphere_count);
  void set_mass(std::size_t body);
  void renumber();
  void prepare_laws();

  // system_lists.cpp
  void refresh();
  void build_outer();
  bool allot();
  void build_inner(std::size_t part);
  void tune();
  std::vector<ContactHistory> collect_histories() const;
  void distribute_histories(const std::vector<ContactHistory>& histories);

  // system_sleep.cpp
  void prepare_cells();
  void check_sleep();
  void wake_all();
  void part_dormant(const std::vector<std::uint32_t>& place_of);
  void freeze(const std::vector<std::uint32_t>& place_of);
  void reset_sleepers();
  PairList dormant_list(const std::vector<std::uint32_t>& place_of) const;
  void set_asleep(std::size_t body, bool asleep);
  void wake_pressed();
  void hold_beyond(double middle, double half_length);
  void mark_held();
  void apply_cells();
  double way_around(double way) const;
  std::size_t cell_of(std::size_t body) const;
  bool loud_nearby(std::size_t cell) const;

  // system_step.cpp
  void step_once();
  void evaluate();
  [[noreturn]] void blame_outside() const;
  [[noreturn]] void blame_overlap() const;
  MotionTask motion_task();
  /// `trace` is made to fit and used when the energy is tracked.
  ContactTask contact_task(PairList& pairs, Column<float>& trace);
  ContactResult evaluate_walls_of(std::size_t slot);

  // energy.cpp
  void record_losses();
  void book_rest(const PairList& list, const Column<float>& trace);
  void book_crossings(const std::array<Column<double>, 2>& before);
  struct ContactEnergy {
    double normal = 0.0;   ///< J, cohesion included
    double springs = 0.0;  ///< tangential and rolling, J
  };
  ContactEnergy energy_of(const PairList& list, std::size_t n) const;
  ContactEnergy energy_of(const WallContacts& contacts, std::size_t k) const;
  ContactEnergy contact_energy(double stiffness, double overlap, double radius, std::uint32_t pair,
                               const std::array<double, 6>& springs) const;
  static std::uint64_t pair_key(std::uint32_t number_a, std::uint32_t number_b);
  std::uint64_t wall_key(const WallSet::Touch& touch) const;

  // system_views.cpp
  double mass_of(std::size_t body) const { return 1.0 / bodies.inverse_mass[body]; }
  /// Public number of the sphere at this place.
  std::uint32_t number_of(std::uint32_t sphere) const {
    const std::uint32_t b = spheres.body[sphere];
    return first_sphere_of_rank[bodies.rank[b]] + (sphere - bodies.first[b]);
  }
  double kinetic_energy(std::size_t body) const;
  Eigen::Vector3d full_velocity(std::size_t body) const;
  Eigen::Vector3d full_momentum(std::size_t body) const;
  Eigen::Matrix3d rotation(std::size_t body) const;
  Eigen::Vector3d spin_of(std::size_t body, const Eigen::Vector3d& momentum) const;
  Eigen::Vector3d momentum_of(std::size_t body, const Eigen::Vector3d& spin) const;
  Particle particle_of(std::size_t body) const;
  std::size_t memory() const;

  WorldSettings settings;
  MaterialTable materials;
  std::vector<ClumpTemplate> templates;
  ShapeTable shapes;
  bool only_spheres = true;
  double time_step = 0.0;
  double rayleigh = 0.0;

  Bodies bodies;
  Spheres spheres;
  std::vector<std::uint32_t> index_of_rank;  ///< place of particle number r
  std::vector<std::uint32_t>
      first_sphere_of_rank;  ///< public number of its first sphere; one more entry at the end

  Period period;
  Quanta quanta;
  ContactLaw law;
  LawTable laws;
  std::unique_ptr<PairCoefficients> coefficients;
  bool many_laws = false;

  ThreadBounds bounds;
  OuterList outer;
  std::vector<PairList> lists;
  std::vector<Column<float>> traces;
  std::vector<ContactHistory> pending;                           ///< histories to be put into the next lists
  bool stale = true;                                             ///< lists must be made from nothing
  bool coefficients_stale = false;                               ///< pair coefficients must be computed again
  double inner_floor = 0.0, outer_floor = 0.0, outer_cap = 0.0;  ///< skins, m
  double inner_steps = 24.0;                                     ///< steps that an inner list shall last
  double outer_steps = 400.0;

  // Sleep: cells of the domain, what sleeping contacts exert, and the histories of these contacts.
  std::array<int, 3> cells{1, 1, 1};
  double cell_size = 0.0;
  std::vector<std::uint32_t> quiet;        ///< looks that found a cell quiet; kAsleep: it sleeps
  std::vector<std::uint8_t> loud;          ///< per cell, of the last check
  std::vector<std::uint8_t> held;          ///< per cell: asleep whatever happens
  std::vector<double> hold;                ///< State::hold
  std::vector<Eigen::Vector3d> looked_at;  ///< per particle number: place at the last look, m
  std::vector<LoadRow> frozen;             ///< per particle number: loads by contacts of sleeping bodies
  std::vector<ContactHistory> dormant;
  std::vector<std::uint32_t> touched_sleepers;  ///< places of sleeping bodies that awake ones may touch
  std::size_t awake_end = 0;                    ///< place of the first sleeping body
  bool regroup = false;                         ///< some body fell asleep or woke: lists must be made anew

  WallSet walls;
  std::unique_ptr<ThreadTeam> team;
  std::int64_t step = 0;
  std::int64_t last_refresh = 0;
  Statistics cost;
  std::size_t touching = 0;
  LossBook losses;
};

}  // namespace wheel_twin::dem
