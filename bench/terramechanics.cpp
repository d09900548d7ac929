// Cost of the semi-empirical contact: static equilibrium under a load, loads at a hub displacement, a whole
// run of the rig. Budget: 50 us an equilibrium on one core.
#include <benchmark/benchmark.h>

#include <cmath>

#include "rig/semi_empirical_contact.h"
#include "terramechanics/wheel_on_soil.h"

namespace {

using namespace wheel_twin;
using terramechanics::Operation;
using terramechanics::Soil;
using terramechanics::Wheel;
using terramechanics::WheelOnSoil;

Wheel amalia(bool rigid) {
  Wheel wheel;
  wheel.grousers = 16;
  wheel.grouser_height = 0.007;
  if (!rigid) wheel.stiffness = 16000.0;
  return wheel;
}

Soil paper_soil(double n) {
  Soil soil;
  soil.n = n;
  soil.k_phi *= std::pow(0.01, 1.0 - n);  // the same pressure at 10 mm
  soil.c1 = 0.1;
  soil.c2 = 0.2;
  return soil;
}

/// Arguments: rigid, slip in percent, steering in degrees, n in percent.
void equilibrium(benchmark::State& state) {
  const WheelOnSoil model(amalia(state.range(0) != 0),
                          paper_soil(static_cast<double>(state.range(3)) / 100.0));
  const Operation operation{static_cast<double>(state.range(1)) / 100.0,
                            static_cast<double>(state.range(2)) * M_PI / 180.0};
  double load = 42.1;
  for ([[maybe_unused]] auto _ : state) {
    load = load > 60.0 ? 42.1 : load + 0.01;
    benchmark::DoNotOptimize(model.at_load(load, operation));
  }
}
BENCHMARK(equilibrium)
    ->ArgNames({"rigid", "slip", "steering", "n"})
    ->Args({1, 30, 0, 100})
    ->Args({0, 30, 0, 100})
    ->Args({0, 30, 0, 80})
    ->Args({0, -30, 0, 100})
    ->Args({0, -95, 0, 100})
    ->Args({0, 30, 15, 100})
    ->Args({0, -30, 15, 100})
    ->Unit(benchmark::kMicrosecond);

/// As the slide moves: a warm start from the last deflection.
void hub_displacement(benchmark::State& state) {
  const WheelOnSoil model(amalia(state.range(0) != 0), paper_soil(1.0));
  double deflection = -1.0, time = 0.0;
  for ([[maybe_unused]] auto _ : state) {
    time += 0.001;
    const double h = 0.012 + 1e-3 * std::sin(10.0 * time);
    const auto loads = model.at_hub_displacement(h, {0.3, 0.0}, {}, deflection);
    deflection = loads.deflection;
    benchmark::DoNotOptimize(model.vertical_stiffness(loads, {0.3, 0.0}));
  }
}
BENCHMARK(hub_displacement)->ArgName("rigid")->Arg(1)->Arg(0)->Unit(benchmark::kMicrosecond);

/// 66 s at 1 kHz through the rig's interface.
void run_of_66_s(benchmark::State& state) {
  for ([[maybe_unused]] auto _ : state) {
    rig::SemiEmpiricalContact contact(amalia(false), paper_soil(1.0));
    rig::HubMotion motion;
    motion.wheel_rate = 0.286;
    motion.velocity.x() = 0.7 * 0.09 * motion.wheel_rate;
    double sum = 0.0;
    for (int i = 0; i < 66000; ++i) {
      motion.time = 0.001 * i;
      motion.position.x() = motion.velocity.x() * motion.time;
      motion.position.z() = -0.012 - 1e-4 * std::sin(motion.time);
      sum += contact.advance(motion).force_hub_rig.x();
    }
    benchmark::DoNotOptimize(sum);
  }
}
BENCHMARK(run_of_66_s)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
