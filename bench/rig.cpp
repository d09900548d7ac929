// The virtual rig's cost on one core: a run of 66 s with all sensors at 1 kHz with its compressed bag
// written, and a quasi-static replay of it as a diagnosis does thousands of times.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "logs/bag_writer.h"
#include "rig/free_run.h"
#include "rig/replay.h"
#include "rig/semi_empirical_contact.h"

namespace {

using namespace wheel_twin;  // NOLINT(google-build-using-namespace): a program, not a header

terramechanics::Wheel amalia() {
  terramechanics::Wheel wheel;
  wheel.grousers = 24;
  wheel.grouser_height = 0.007;
  wheel.stiffness = 9000.0;
  return wheel;
}

rig::RunSettings settings() {
  rig::RunSettings set;
  set.conditions.slip = 0.6;
  set.sensors.joints.rate = 1000.0;
  set.sensors.temperature.rate = 1000.0;
  set.sensors.ft.noise.setConstant(0.02);
  set.sensors.ft.resolution << 0.0625, 0.0625, 0.0625, 1.0 / 752, 1.0 / 752, 1.0 / 1504;
  set.sensors.ft.low_pass = 73.0;
  set.sensors.draw_wire.noise = 1e-5;
  set.sensors.joints.effort_noise = 0.015;
  set.sensors.joints.wheel_rate_noise = 5e-4;
  set.sensors.joints.carriage_velocity_noise = 5e-5;
  return set;
}

run_log::RunLog simulated(double& seconds) {
  rig::SemiEmpiricalContact contact(amalia(), {});
  rig::FreeRun run(settings(), contact, {});
  rig::RunSummary summary;
  run_log::RunLog log = rig::run_to_end(run, summary);
  seconds = run.time();
  return log;
}

void virtual_run_with_bag(benchmark::State& state) {
  const std::string bag = (std::filesystem::temp_directory_path() / "bench_rig.bag").string();
  double seconds = 0.0;
  for (auto _ : state) logs::write_bag(simulated(seconds), bag);
  state.counters["simulated_s"] = seconds;
  state.counters["bag_MB"] = 1e-6 * static_cast<double>(std::filesystem::file_size(bag));
  std::filesystem::remove(bag);
}
BENCHMARK(virtual_run_with_bag)->Unit(benchmark::kMillisecond);

void virtual_run_alone(benchmark::State& state) {
  double seconds = 0.0;
  for (auto _ : state) benchmark::DoNotOptimize(simulated(seconds));
}
BENCHMARK(virtual_run_alone)->Unit(benchmark::kMillisecond);

void bag_alone(benchmark::State& state) {
  const std::string bag = (std::filesystem::temp_directory_path() / "bench_rig.bag").string();
  const auto compression = static_cast<logs::Compression>(state.range(0));
  double seconds = 0.0;
  const run_log::RunLog log = simulated(seconds);
  for (auto _ : state) logs::write_bag(log, bag, compression);
  state.counters["bag_MB"] = 1e-6 * static_cast<double>(std::filesystem::file_size(bag));
  std::filesystem::remove(bag);
}
BENCHMARK(bag_alone)
    ->Arg(static_cast<int>(logs::Compression::lz4))
    ->Arg(static_cast<int>(logs::Compression::bz2))
    ->ArgName("compression")
    ->Unit(benchmark::kMillisecond);

/// Steps of range(0) milliseconds.
void quasi_static_replay(benchmark::State& state) {
  double seconds = 0.0;
  const run_log::RunLog log = simulated(seconds);
  const rig::MotionSeries motion = rig::motion_of_log(log, settings().conditions);
  rig::SampleTimes times;
  for (double t = 0.0; t < seconds; t += 0.02) times.wrench.push_back(t);
  times.displacement = times.effort = times.wrench;
  rig::ReplayOptions options;
  options.step = 1e-3 * static_cast<double>(state.range(0));
  for (auto _ : state) {
    rig::SemiEmpiricalContact contact(amalia(), {});
    benchmark::DoNotOptimize(
        rig::predict(settings().rig, settings().conditions, 0.09, contact, {}, motion, times, options));
  }
}
BENCHMARK(quasi_static_replay)->Arg(20)->Arg(100)->ArgName("step_ms")->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
