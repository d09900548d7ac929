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
  int threads = 1;
  int steps = 2000;
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

void run(const Options& options) {
  if (options.bed != "clumps" && options.bed != "spheres") throw Error("--bed is clumps or spheres");
  dem::GranularSoil soil = dem::load_granular_soil(options.soil);
  dem::ReferenceBed bed;
  bed.clumps = options.bed == "clumps";
  bed.spheres = options.spheres;
  bed.threads = options.threads;
  if (!bed.clumps) {
    soil.grain.shear_modulus = 2e7;
    soil.grain_grain.friction = 0.5;
  }
  dem::System system = dem::make_reference_world(bed, soil);
  struct stat information;
  if (!options.state.empty() && stat(options.state.c_str(), &information) == 0) {
    dem::restore_checkpoint(options.state, system);
  } else {
    Progress progress("settling", 1.0);
    dem::settle_reference_bed(system, bed, soil, [&](double done) { progress.update(done); });
    if (!options.state.empty()) dem::write_checkpoint(options.state, system);
  }
  if (!options.lammps.empty()) write_file(options.lammps, dem::lammps_data(system));
  if (options.steps == 0) return;
  system.step(std::max(100, options.steps / 10));
  const dem::Statistics before = system.statistics();
  const double start = now();
  system.step(options.steps);
  const double seconds = now() - start;
  const dem::Statistics after = system.statistics();
  const auto spheres = static_cast<double>(system.sphere_count());
  const double updates = spheres * options.steps / seconds;
  const double bandwidth = memory_bandwidth();
  const auto share = [&](double from, double to) { return 1e9 * (to - from) / (spheres * options.steps); };
  nlohmann::json result;
  result["bed"] = options.bed;
  result["spheres"] = system.sphere_count();
  result["particles"] = system.size();
  result["threads"] = options.threads;
  result["steps"] = options.steps;
  result["instruction_set"] = dem::instruction_set();
  result["sphere_updates_per_second"] = updates;
  result["nanoseconds_per_sphere_step"] = {
      {"whole", 1e9 * seconds / (spheres * options.steps)},
      {"contacts", share(before.seconds_contacts, after.seconds_contacts)},
      {"walls", share(before.seconds_walls, after.seconds_walls)},
      {"motion", share(before.seconds_motion, after.seconds_motion)},
      {"lists", share(before.seconds_lists, after.seconds_lists)}};
  result["contacts_per_sphere"] = static_cast<double>(after.contacts) / spheres;
  result["candidates_per_sphere"] = static_cast<double>(after.candidates) / spheres;
  result["list_refreshes"] = after.list_refreshes - before.list_refreshes;
  result["list_builds"] = after.list_builds - before.list_builds;
  result["bytes_per_sphere"] = static_cast<double>(after.memory_bytes) / spheres;
  result["bytes_per_second"] = after.bytes_per_step * options.steps / seconds;
  result["machine_bytes_per_second"] = bandwidth;
  if (!options.json.empty()) write_file(options.json, result.dump(2) + "\n");
  const auto& parts = result["nanoseconds_per_sphere_step"];
  fmt::print(
      "{} bed: {} spheres in {} particles, {} thread(s), {}\n"
      "  {:.2f} million sphere updates per second ({:.1f} ns per sphere and step over {} steps)\n"
      "  contacts {:.1f} ns (walls {:.1f} of these), motion {:.1f} ns, lists {:.1f} ns ({} refreshes, {} "
      "builds)\n"
      "  {:.2f} touching pairs and {:.2f} candidates per sphere, {:.0f} bytes per sphere\n"
      "  {:.1f} GB/s moved at least, {:.1f} GB/s is what one core moves in a streaming loop\n",
      options.bed, system.sphere_count(), system.size(), options.threads, dem::instruction_set(),
      1e-6 * updates, 1e9 * seconds / (spheres * options.steps), options.steps,
      parts["contacts"].get<double>(), parts["walls"].get<double>(), parts["motion"].get<double>(),
      parts["lists"].get<double>(), result["list_refreshes"].get<int>(), result["list_builds"].get<int>(),
      result["contacts_per_sphere"].get<double>(), result["candidates_per_sphere"].get<double>(),
      result["bytes_per_sphere"].get<double>(), 1e-9 * result["bytes_per_second"].get<double>(),
      1e-9 * bandwidth);
}

}  // namespace

void add_bench(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "bench",
      "Throughput of the granular engine on this machine: settles a bed, then times steps.\n"
      "Example: twin bench --bed clumps --spheres 80000 --state clumps.h5");
  auto options = std::make_shared<Options>();
  command->add_option("--bed", options->bed, "clumps or spheres")->capture_default_str();
  command->add_option("--soil", options->soil, "soil file of the clumps")->capture_default_str();
  command->add_option("--spheres", options->spheres, "size of the bed")->capture_default_str();
  command->add_option("--threads", options->threads, "threads")->capture_default_str();
  command->add_option("--steps", options->steps, "steps to time; 0: settle only")->capture_default_str();
  command->add_option("--state", options->state, "settled bed: read when it is there, else written");
  command->add_option("--lammps", options->lammps, "write the bed as a LAMMPS data file");
  command->add_option("--json", options->json, "write the numbers to this file");
  command->callback([options] { run(*options); });
}

}  // namespace wheel_twin::cli
