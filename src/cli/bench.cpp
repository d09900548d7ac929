// `twin bench`: throughput of the granular engine on this machine.
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/progress.h"
#include "cli/commands.h"
#include "dem/kernels.h"
#include "dem/reference_bed.h"
#include "dem/state_file.h"

namespace wheel_twin::cli {
namespace {

struct Options {
  std::string bed = "clumps";
  std::string soil = "mars_simulant";
  std::size_t spheres = 20000;
  std::vector<int> threads{1};
  std::size_t growth = 0;
  int steps = 2000;
  int rounds = 1;
  bool sleep = false;
  std::string state, lammps, json;
};

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Bytes a second that one core moves: a = b + 3 c over arrays larger than the caches, best of five.
double memory_bandwidth() {
  const std::size_t n = 16U << 20U;
  std::vector<double> a(n, 0.0);
  const std::vector<double> b(n, 1.0);
  const std::vector<double> c(n, 2.0);
  double best = 1e30;
  for (int round = 0; round < 5; ++round) {
    const double start = now();
    for (std::size_t k = 0; k < n; ++k) a[k] = b[k] + 3.0 * c[k];
    best = std::min(best, now() - start + 1e-12 * a[n / 2]);
  }
  return 24.0 * static_cast<double>(n) / best;
}

/// One run of `steps` steps as JSON; the same keys for every bed and number of threads.
nlohmann::json measure(dem::System& system, int threads, int steps) {
  system.set_threads(threads);
  system.step(std::max(100, steps / 10));
  const dem::Statistics before = system.statistics();
  const double start = now();
  system.step(steps);
  const double seconds = now() - start;
  const dem::Statistics after = system.statistics();
  const auto spheres = static_cast<double>(system.sphere_count());
  const double updates = spheres * steps;
  const auto share = [&](double from, double to) { return 1e9 * (to - from) / updates; };
  return {{"spheres", system.sphere_count()},
          {"particles", system.size()},
          {"threads", threads},
          {"steps", steps},
          {"sphere_updates_per_second", updates / seconds},
          {"nanoseconds_per_sphere_step",
           {{"whole", 1e9 * seconds / updates},
            {"contacts", share(before.seconds_contacts, after.seconds_contacts)},
            {"walls", share(before.seconds_walls, after.seconds_walls)},
            {"motion", share(before.seconds_motion, after.seconds_motion)},
            {"lists", share(before.seconds_lists, after.seconds_lists)}}},
          {"contacts_per_sphere", static_cast<double>(after.contacts) / spheres},
          {"candidates_per_sphere", static_cast<double>(after.candidates) / spheres},
          {"list_refreshes", after.list_refreshes - before.list_refreshes},
          {"list_builds", after.list_builds - before.list_builds},
          {"bytes_per_sphere", static_cast<double>(after.memory_bytes) / spheres},
          {"bytes_per_second", after.bytes_per_step * steps / seconds}};
}

double updates_of(const nlohmann::json& result) {
  return result["sphere_updates_per_second"].get<double>();
}

/// Of several rounds the one with the median speed.
nlohmann::json median(std::vector<nlohmann::json> rounds) {
  std::sort(rounds.begin(), rounds.end(),
            [](const auto& a, const auto& b) { return updates_of(a) < updates_of(b); });
  return rounds[rounds.size() / 2];
}

void print(const nlohmann::json& r) {
  const auto& parts = r["nanoseconds_per_sphere_step"];
  const auto number = [](const nlohmann::json& value) { return value.get<double>(); };
  fmt::print(
      "{} spheres in {} particles, {} thread(s)\n"
      "  {:.2f} million sphere updates per second ({:.1f} ns per sphere and step over {} steps)\n"
      "  contacts {:.1f} ns (walls {:.1f} of these), motion {:.1f} ns, lists {:.1f} ns ({} refreshes, {} "
      "builds)\n"
      "  {:.2f} touching pairs and {:.2f} candidates per sphere, {:.0f} bytes per sphere, {:.1f} GB/s moved "
      "at "
      "least\n",
      r["spheres"].get<std::size_t>(), r["particles"].get<std::size_t>(), r["threads"].get<int>(),
      1e-6 * updates_of(r), number(parts["whole"]), r["steps"].get<int>(), number(parts["contacts"]),
      number(parts["walls"]), number(parts["motion"]), number(parts["lists"]), r["list_refreshes"].get<int>(),
      r["list_builds"].get<int>(), number(r["contacts_per_sphere"]), number(r["candidates_per_sphere"]),
      number(r["bytes_per_sphere"]), 1e-9 * number(r["bytes_per_second"]));
}

/// The bed with each number of threads in turn, `rounds` times.
std::vector<nlohmann::json> compare_threads(dem::System& system, const Options& options) {
  std::vector<std::vector<nlohmann::json>> rounds(options.threads.size());
  for (int round = 0; round < options.rounds; ++round) {
    for (std::size_t t = 0; t < options.threads.size(); ++t)
      rounds[t].push_back(measure(system, options.threads[t], options.steps));
  }
  std::vector<nlohmann::json> results;
  for (auto& each : rounds) results.push_back(median(std::move(each)));
  return results;
}

/// Copies of the settled bed side by side, up to options.growth spheres, on one thread.
std::vector<nlohmann::json> grow(const dem::System& settled, const dem::ReferenceBed& bed,
                                 const dem::GranularSoil& soil, const Options& options) {
  std::vector<dem::System> systems;
  for (int across = 1;; ++across) {
    // Sizes grow by about two: 1 x 1, 1 x 2, 2 x 2, 2 x 4, ...
    const int x = 1 << (across - 1) / 2;
    const int y = 1 << across / 2;
    const std::size_t spheres = settled.sphere_count() * static_cast<std::size_t>(x * y);
    if (spheres > options.growth) break;
    systems.push_back(dem::tiled_reference_bed(settled, bed, soil, x, y));
  }
  if (systems.size() < 2) throw Error("--growth must be at least twice --spheres");
  std::vector<std::vector<nlohmann::json>> rounds(systems.size());
  Progress progress("growth", static_cast<double>(options.rounds) * static_cast<double>(systems.size()));
  double done = 0.0;
  for (int round = 0; round < options.rounds; ++round) {
    for (std::size_t k = 0; k < systems.size(); ++k) {
      rounds[k].push_back(measure(systems[k], 1, options.steps));
      progress.update(++done);
    }
  }
  std::vector<nlohmann::json> results;
  for (auto& each : rounds) results.push_back(median(std::move(each)));
  return results;
}

/// The same bed, its parts at rest asleep: the speed after as many steps as put them to sleep.
nlohmann::json asleep(const dem::System& settled, dem::ReferenceBed bed, const dem::GranularSoil& soil,
                      const Options& options) {
  constexpr int falling_asleep = 10000;  // steps
  bed.sleep.enabled = true;
  dem::System system = dem::make_reference_world(bed, soil);
  system.restore(settled.state());
  system.step(falling_asleep);
  std::vector<nlohmann::json> rounds;
  for (int round = 0; round < options.rounds; ++round) rounds.push_back(measure(system, 1, options.steps));
  nlohmann::json result = median(std::move(rounds));
  result["asleep"] = static_cast<double>(system.statistics().sleeping) / static_cast<double>(system.size());
  return result;
}

dem::System settled_bed(const dem::ReferenceBed& bed, const dem::GranularSoil& soil, const Options& options) {
  dem::System system = dem::make_reference_world(bed, soil);
  struct stat information;
  if (!options.state.empty() && stat(options.state.c_str(), &information) == 0) {
    dem::restore_checkpoint(options.state, system);
  } else {
    Progress progress("settling", 1.0);
    dem::settle_reference_bed(system, bed, soil, [&](double done) { progress.update(done); });
    if (!options.state.empty()) dem::write_checkpoint(options.state, system);
  }
  return system;
}

void run(const Options& options) {
  if (options.bed != "clumps" && options.bed != "spheres") throw Error("--bed is clumps or spheres");
  dem::GranularSoil soil = dem::load_granular_soil(options.soil);
  dem::ReferenceBed bed;
  bed.clumps = options.bed == "clumps";
  bed.spheres = options.spheres;
  bed.threads = options.threads.front();
  if (!bed.clumps) {
    soil.grain.shear_modulus = 2e7;
    soil.grain_grain.friction = 0.5;
  }
  dem::System system = settled_bed(bed, soil, options);
  if (!options.lammps.empty()) write_file(options.lammps, dem::lammps_data(system));
  if (options.steps == 0) return;
  const std::vector<nlohmann::json> results = compare_threads(system, options);
  const double bandwidth = memory_bandwidth();
  nlohmann::json report = results.front();
  report["bed"] = options.bed;
  report["instruction_set"] = dem::instruction_set();
  report["machine_bytes_per_second"] = bandwidth;
  fmt::print("{} bed, {}; one core streams {:.1f} GB/s\n", options.bed, dem::instruction_set(),
             1e-9 * bandwidth);
  for (const auto& result : results) print(result);
  for (std::size_t t = 1; t < results.size(); ++t) {
    const double speedup = updates_of(results[t]) / updates_of(results[0]);
    report["by_threads"] = results;
    report["speedup"].push_back(speedup);
    fmt::print("{} threads are {:.2f} times as fast as {}\n", options.threads[t], speedup,
               options.threads[0]);
  }
  if (options.growth > 0) {
    const std::vector<nlohmann::json> sizes = grow(system, bed, soil, options);
    for (const auto& result : sizes) print(result);
    report["growth"] = sizes;
    report["growth_ratio"] = updates_of(sizes.front()) / updates_of(sizes.back());
    fmt::print("a step of {} spheres takes {:.2f} times as long per sphere as one of {}\n",
               sizes.back()["spheres"].get<std::size_t>(), report["growth_ratio"].get<double>(),
               sizes.front()["spheres"].get<std::size_t>());
  }
  if (options.sleep) {
    const nlohmann::json result = asleep(system, bed, soil, options);
    report["sleep"] = result;
    fmt::print("{:.1f} % asleep: a step takes {:.3f} of the time\n", 100.0 * result["asleep"].get<double>(),
               updates_of(results.front()) / updates_of(result));
  }
  if (!options.json.empty()) write_file(options.json, report.dump(2) + "\n");
}

}  // namespace

void add_bench(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "bench",
      "Throughput of the granular engine on this machine: settles a bed, then times steps.\n"
      "Example: twin bench --bed clumps --spheres 80000 --state clumps.h5 --threads 1,2");
  auto options = std::make_shared<Options>();
  command->add_option("--bed", options->bed, "clumps or spheres")->capture_default_str();
  command->add_option("--soil", options->soil, "soil file of the clumps")->capture_default_str();
  command->add_option("--spheres", options->spheres, "size of the bed")
      ->capture_default_str()
      ->check(CLI::Range(500, 100000000));
  command->add_option("--threads", options->threads, "threads; several, as 1,2: measured in turn")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command->add_option("--growth", options->growth,
                      "copies of the bed side by side, doubled up to this many spheres, on one thread");
  command->add_flag("--sleep", options->sleep, "also with the parts at rest asleep, on one thread");
  command->add_option("--steps", options->steps, "steps to time; 0: settle only")
      ->capture_default_str()
      ->check(CLI::Range(0, 100000000));
  command->add_option("--rounds", options->rounds, "measured so often in turn; the medians are printed")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_option("--state", options->state, "settled bed: read when it is there, else written");
  command->add_option("--lammps", options->lammps, "write the bed as a LAMMPS data file");
  command->add_option("--json", options->json, "write the numbers to this file");
  command->callback([options] { run(*options); });
}

}  // namespace wheel_twin::cli
