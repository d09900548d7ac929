#include "dem/bed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "base/error.h"
#include "base/progress.h"
#include "base/random.h"
#include "dem/archive.h"
#include "dem/cache.h"
#include "dem/cloud.h"
#include "dem/limits.h"
#include "dem/settle.h"
#include "dem/state_file.h"

namespace wheel_twin::dem {
namespace {

constexpr int method_version = 5;       // of the recipe below: a change of it changes every bed
constexpr double highest_excess = 0.5;  // of the friction while filling over the grains' own
constexpr double headroom = 0.1;        // m over the cloud: a grain may be thrown up

double grain_size(const GranularSoil& soil) {
  return 2.0 * soil.clumps.smallest_radius() / soil.clumps.smallest_size;
}

// Two grain diameters from floor and surface, where the density is not that of the bulk.
double margin_of(const GranularSoil& soil) {
  return 2.0 * grain_size(soil);
}

Box inner_region(const GranularSoil& soil, const BedSettings& s, double surface = 0.0) {
  const double margin = margin_of(soil);
  const double side_x = s.periodic_x ? 0.0 : margin;
  const double side_y = s.periodic_y ? 0.0 : margin;
  return {{side_x, -0.5 * s.width + side_y, -s.depth + margin},
          {s.length - side_x, 0.5 * s.width - side_y, surface - margin}};
}

// Height that has to be filled so that a level surface can be cut at z = 0.
double overfill(const GranularSoil& soil) {
  return 1.5 * grain_size(soil);
}

std::size_t clump_count(const GranularSoil& soil, const BedSettings& s) {
  const double volume = s.length * s.width * (s.depth + overfill(soil));
  return static_cast<std::size_t>(std::ceil(soil.packing_density * volume / soil.clumps.mean_volume()));
}

double cloud_height(const GranularSoil& soil, const BedSettings& s) {
  return static_cast<double>(clump_count(soil, s)) * soil.clumps.mean_volume() /
         (s.length * s.width * s.cloud_density);
}

// What goes beyond the grains' own friction resists rolling.
PairProperties while_filling(const GranularSoil& soil, double fill_friction) {
  PairProperties pair = soil.grain_grain;
  pair.friction = std::min(fill_friction, soil.grain_grain.friction);
  pair.rolling_friction += std::max(0.0, fill_friction - soil.grain_grain.friction);
  return pair;
}

// Gives the grains their own friction back. Grains that lose their hold creep to the nearest rest, their
// velocities being taken away again and again, instead of falling and compacting the bed.
void restore_friction(const GranularSoil& soil, System& system) {
  system.set_pair(GranularSoil::grain_material, GranularSoil::grain_material, soil.grain_grain);
  for (int i = 0; i < 200; ++i) {
    system.stop_all();
    system.step(50);
  }
}

System clouded_system(const GranularSoil& soil, const BedSettings& s, double friction, int threads) {
  const double height = cloud_height(soil, s);
  System system = bed_world(soil, s, height - s.depth + headroom, threads);
  Random random(s.seed);
  CloudRegion region;
  region.low = {0.0, -0.5 * s.width, -s.depth};
  region.high = {s.length, 0.5 * s.width, height - s.depth};
  region.periodic_x = s.periodic_x;
  region.periodic_y = s.periodic_y;
  system.add(random_cloud(soil.clumps, region, clump_count(soil, s), random, GranularSoil::grain_material));
  system.set_pair(GranularSoil::grain_material, GranularSoil::grain_material, while_filling(soil, friction));
  return system;
}

SettleSettings fall_settings(const GranularSoil& soil, const BedSettings& s) {
  SettleSettings settings;
  settings.shortest_time = std::sqrt(2.0 * std::max(0.0, cloud_height(soil, s) - s.depth) / s.gravity);
  settings.length = 0.5 * grain_size(soil);
  return settings;
}

double tuned_friction(const GranularSoil& soil, const BedSettings& s, int threads) {
  // Columns of 14 grains a side came out up to 0.004 off the bed they stood for.
  const double side = 20.0 * grain_size(soil);
  BedSettings column = s;
  column.periodic_x = column.periodic_y = true;
  column.length = std::min(s.length, side);
  column.width = std::min(s.width, side);
  Progress progress("bed: friction while filling", 12.0);
  double evaluations = 0.0;
  const auto density = [&](double friction) {
    System system = clouded_system(soil, column, friction, threads);
    const SettleSettings fall = fall_settings(soil, column);
    settle(system, fall);
    restore_friction(soil, system);
    SettleSettings rest = fall;
    rest.shortest_time = 0.01;
    settle(system, rest);
    progress.update(++evaluations);
    return packing_density(system, inner_region(soil, column));
  };
  constexpr double tolerance = 0.002;
  constexpr double allowed = 0.005;  // where the wanted density is the edge of what can be had
  const double own = soil.grain_grain.friction;
  const double target = soil.packing_density;
  const double at_own = density(own);
  if (std::abs(at_own - target) <= tolerance) return own;
  if (at_own < target)
    return tune_friction(target, own, tolerance, [&](double mu) { return mu == own ? at_own : density(mu); });
  // Beyond a rolling friction of a half packings get no looser.
  const double loosest = density(own + highest_excess);
  if (loosest > target && loosest - target < allowed) return own + highest_excess;
  return own + tune_friction(target, highest_excess, tolerance, [&](double excess) {
           return excess == highest_excess ? loosest : density(own + excess);
         });
}

// Cuts the bed so that the mean of the surface lies at z = 0.
void level_surface(System& system, const BedSettings& s, double grain) {
  const std::vector<Particle> particles = system.particles();
  const std::vector<SphereState> spheres = system.spheres();
  const Box region{{0.0, -0.5 * s.width, -s.depth}, {s.length, 0.5 * s.width, 0.0}};
  const auto surface_of = [&](double cut) {
    std::vector<SphereState> kept;
    for (const SphereState& sphere : spheres)
      if (particles[sphere.particle].position.z() <= cut) kept.push_back(sphere);
    return mean_height(height_map(kept, region, grain / 4.0));
  };
  double low = -2.0 * grain;
  double high = 2.0 * grain;
  if (surface_of(high) < 0.0)
    throw Error(fmt::format("bed: its surface is {:.1f} mm below the wanted depth", -1e3 * surface_of(high)));
  for (int i = 0; i < 20; ++i) {
    const double cut = 0.5 * (low + high);
    (surface_of(cut) < 0.0 ? low : high) = cut;
  }
  std::vector<bool> above(particles.size());
  for (std::size_t i = 0; i < particles.size(); ++i) above[i] = particles[i].position.z() > high;
  system.remove(above);
}

BedReport measure(const GranularSoil& soil, const BedSettings& s, const System& system,
                  double fill_friction) {
  BedReport report;
  report.clumps = system.size();
  report.spheres = system.sphere_count();
  report.fill_friction = fill_friction;
  report.margin = margin_of(soil);
  const Box inner = inner_region(soil, s);
  report.packing_density = packing_density(system, inner);
  Box whole = inner;
  whole.low.z() = -s.depth;
  whole.high.z() = 0.0;
  report.layer_density = layer_densities(system, whole, 0.01);
  report.layer_thickness = s.depth / static_cast<double>(report.layer_density.size());
  report.kinetic_energy = system.energy().kinetic;
  for (std::size_t i = 0; i < system.size(); ++i) report.weight += system.mass(i) * s.gravity;
  report.floor_force = -system.wall_wrench(0).force.z();
  report.coordination = coordination(system, inner);
  report.simulated_time = system.time();
  return report;
}

// The phases of making a bed, in the order in which a checkpoint may find them.
enum class Phase { filling, friction_restored, levelled };

struct Unfinished {
  Phase phase = Phase::filling;
  double fill_friction = 0.0;
  double phase_start = 0.0;
};

void write_unfinished(const std::string& path, const System& system, const Unfinished& work) {
  Archive archive;
  store(system.state(), archive);
  archive.set_text("system", system_fingerprint(system));
  archive.set_number("phase", static_cast<double>(work.phase));
  archive.set_number("fill_friction", work.fill_friction);
  archive.set_number("phase_start", work.phase_start);
  write_archive(path, "checkpoint", archive);
}

}  // namespace

std::string bed_description(const GranularSoil& soil, const BedSettings& s) {
  return fmt::format(
      "bed {}\n{}packing {} size {} {} {} periodic {} {} gravity {} seed {} cloud {} fill friction {}\n",
      method_version, soil.fingerprint(), soil.packing_density, s.length, s.width, s.depth, s.periodic_x,
      s.periodic_y, s.gravity, s.seed, s.cloud_density,
      s.fill_friction ? fmt::format("{}", *s.fill_friction) : "tuned");
}

System bed_world(const GranularSoil& soil, const BedSettings& s, double headroom, int threads,
                 const SleepSettings& sleep) {
  WorldSettings world;
  const double pad_x = s.periodic_x ? 0.0 : 0.01;
  const double pad_y = s.periodic_y ? 0.0 : 0.01;
  world.low = {-pad_x, -0.5 * s.width - pad_y, -s.depth - 0.01};
  world.high = {s.length + pad_x, 0.5 * s.width + pad_y, headroom};
  world.periodic_x = s.periodic_x;
  world.periodic_y = s.periodic_y;
  world.gravity = {0.0, 0.0, -s.gravity};
  world.step_fraction = soil.step_fraction;
  world.smallest_size = soil.clumps.smallest_size * (1.0 - 1e-6);  // sizes are rounded to single precision
  world.threads = threads;
  world.sleep = sleep;
  System system(world, soil.materials(), soil.clumps.shapes);
  const auto add_plane = [&](const char* name, const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    Wall wall;
    wall.name = name;
    wall.material = GranularSoil::wall_material;
    wall.shape = HalfSpace{normal};
    wall.pose.position = point;
    system.add_wall(wall);
  };
  add_plane("floor", {0.0, 0.0, -s.depth}, Eigen::Vector3d::UnitZ());
  if (!s.periodic_x) {
    add_plane("back wall", {0.0, 0.0, 0.0}, Eigen::Vector3d::UnitX());
    add_plane("front wall", {s.length, 0.0, 0.0}, -Eigen::Vector3d::UnitX());
  }
  if (!s.periodic_y) {
    add_plane("right wall", {0.0, -0.5 * s.width, 0.0}, Eigen::Vector3d::UnitY());
    add_plane("left wall", {0.0, 0.5 * s.width, 0.0}, -Eigen::Vector3d::UnitY());
  }
  return system;
}

Bed make_bed(const GranularSoil& soil, const BedSettings& s, int threads,
             const std::string& checkpoint_path) {
  check_bed(soil, s);
  Unfinished work;
  std::optional<System> made;
  if (!checkpoint_path.empty() && std::filesystem::exists(checkpoint_path)) {
    const Archive archive = read_archive(checkpoint_path, "checkpoint");
    work.phase = static_cast<Phase>(static_cast<int>(archive.number("phase")));
    work.fill_friction = archive.number("fill_friction");
    work.phase_start = archive.number("phase_start");
    made.emplace(bed_world(soil, s, cloud_height(soil, s) - s.depth + headroom, threads));
    if (archive.text("system") != system_fingerprint(*made))
      throw Error(fmt::format("{}: belongs to another bed", checkpoint_path));
    made->restore(load_state(archive));
    if (work.phase == Phase::filling) {
      made->set_pair(GranularSoil::grain_material, GranularSoil::grain_material,
                     while_filling(soil, work.fill_friction));
    }
  } else {
    work.fill_friction = s.fill_friction ? *s.fill_friction : tuned_friction(soil, s, threads);
    made.emplace(clouded_system(soil, s, work.fill_friction, threads));
  }
  System& system = *made;

  const SettleSettings fall = fall_settings(soil, s);
  SettleSettings rest = fall;
  rest.shortest_time = 0.01;
  Progress progress("bed: settling", fall.shortest_time + 0.4);
  auto written = std::chrono::steady_clock::now();
  const auto run_phase = [&](SettleSettings settings) {
    const double before = system.time() - work.phase_start;
    settings.shortest_time = std::max(0.0, settings.shortest_time - before);
    settle(system, settings, [&](double) {
      progress.update(system.time());
      const auto now = std::chrono::steady_clock::now();
      if (checkpoint_path.empty() || now - written < std::chrono::minutes(1)) return;
      write_unfinished(checkpoint_path, system, work);
      written = now;
    });
    work.phase_start = system.time();
  };
  if (work.phase == Phase::filling) {
    run_phase(fall);
    restore_friction(soil, system);
    work.phase = Phase::friction_restored;
  }
  if (work.phase == Phase::friction_restored) {
    run_phase(rest);
    level_surface(system, s, grain_size(soil));
    work.phase = Phase::levelled;
  }
  run_phase(rest);

  Bed bed;
  bed.settings = s;
  bed.report = measure(soil, s, system, work.fill_friction);
  bed.state = system.state();
  if (!checkpoint_path.empty()) {
    std::error_code ignored;
    std::filesystem::remove(checkpoint_path, ignored);
  }
  return bed;
}

namespace {

Archive to_archive(const Bed& bed) {
  Archive archive;
  store(bed.state, archive);
  const BedSettings& s = bed.settings;
  archive.set("bed_settings", std::vector<double>{s.length, s.width, s.depth, s.periodic_x ? 1.0 : 0.0,
                                                  s.periodic_y ? 1.0 : 0.0, s.gravity,
                                                  static_cast<double>(s.seed), s.cloud_density});
  const BedReport& r = bed.report;
  archive.set("bed_report",
              std::vector<double>{static_cast<double>(r.clumps), static_cast<double>(r.spheres),
                                  r.fill_friction, r.packing_density, r.margin, r.layer_thickness,
                                  r.kinetic_energy, r.weight, r.floor_force, r.coordination.per_clump,
                                  r.coordination.per_sphere, r.simulated_time});
  archive.set("layer_density", r.layer_density);
  return archive;
}

Bed from_archive(const Archive& archive) {
  Bed bed;
  bed.state = load_state(archive);
  const auto& s = archive.get<double>("bed_settings");
  const auto& r = archive.get<double>("bed_report");
  if (s.size() != 8 || r.size() != 12) throw Error("bed: its settings or its report are incomplete");
  bed.settings.length = s[0];
  bed.settings.width = s[1];
  bed.settings.depth = s[2];
  bed.settings.periodic_x = s[3] != 0.0;
  bed.settings.periodic_y = s[4] != 0.0;
  bed.settings.gravity = s[5];
  bed.settings.seed = static_cast<std::uint64_t>(s[6]);
  bed.settings.cloud_density = s[7];
  bed.report = {static_cast<std::size_t>(r[0]),
                static_cast<std::size_t>(r[1]),
                r[2],
                r[3],
                r[4],
                r[5],
                archive.get<double>("layer_density"),
                r[6],
                r[7],
                r[8],
                {r[9], r[10]},
                r[11]};
  bed.settings.fill_friction = bed.report.fill_friction;
  return bed;
}

}  // namespace

Bed fetch_bed(const GranularSoil& soil, const BedSettings& settings, int threads) {
  const std::string description = bed_description(soil, settings);
  const std::string checkpoint = cache_path("unfinished", description);
  return from_archive(
      fetch("bed", description, [&] { return to_archive(make_bed(soil, settings, threads, checkpoint)); }));
}

System bed_system(const GranularSoil& soil, const Bed& bed, double headroom, int threads,
                  const SleepSettings& sleep) {
  System system = bed_world(soil, bed.settings, headroom, threads, sleep);
  system.restore(bed.state);
  return system;
}

void write_bed(const std::string& path, const Bed& bed, const std::string& description) {
  Archive archive = to_archive(bed);
  archive.set_text("description", description);
  write_archive(path, "bed", archive);
}

Bed read_bed(const std::string& path) {
  return from_archive(read_archive(path, "bed"));
}

}  // namespace wheel_twin::dem
