// Cost of a step of the paper's two wheels (hub prescribed, rolling, vibrating) and of rims of other segment
// counts. Last line: amalia_us X t0_r0_us Y, microseconds a step on one core, the better of three runs each.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "wheel/calibration.h"
#include "wheel/flexible_wheel.h"

namespace {

using namespace wheel_twin::wheel;

WheelModel wheel_file(const std::string& name, int segments = 64, int beam_bodies = 12) {
  WheelModel model = read_wheel_file(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels/" + name + ".yaml");
  model.segments = segments;
  model.rim_joint_stiffness *= segments / 64.0;
  model.beams.bodies = beam_bodies;
  model.max_substeps = 1;
  return model;
}

/// A wheel that rolls at 1 rad/s with a load moving around its rim, so that joints turn and springs stretch.
class Roller {
 public:
  explicit Roller(const WheelModel& model) : wheel_(model), dt_(std::min(1.5e-5, wheel_.stable_step())) {
    hub_.rate = 1.0;
    wheel_.place(hub_);
  }
  void step() {
    time_ += dt_;
    hub_.angle = time_;
    const int bottom = wheel_.segment_count() / 2;
    wheel_.apply(bottom, {5.0 * std::sin(3000.0 * time_), 0.0, 42.1}, Eigen::Vector3d::Zero());
    wheel_.step(dt_, hub_);
  }
  int bodies() const { return wheel_.body_count(); }

 private:
  FlexibleWheel wheel_;
  HubMotion hub_;
  double dt_;
  double time_ = 0.0;
};

void run(benchmark::State& state, const WheelModel& model) {
  Roller roller(model);
  for (int i = 0; i < 500; ++i) roller.step();
  for (auto _ : state) roller.step();
  state.counters["bodies"] = roller.bodies();
}
void amalia(benchmark::State& state) {
  run(state, wheel_file("amalia", static_cast<int>(state.range(0))));
}
void t0_r0(benchmark::State& state) {
  run(state, wheel_file("t0_r0", 64, static_cast<int>(state.range(0))));
}
BENCHMARK(amalia)->Arg(32)->Arg(64)->Arg(128)->Arg(256)->Unit(benchmark::kMicrosecond);
BENCHMARK(t0_r0)->Arg(3)->Arg(6)->Arg(12)->Arg(24)->Unit(benchmark::kMicrosecond);

double microseconds(const std::string& name, int steps) {
  Roller roller(wheel_file(name));
  for (int i = 0; i < 500; ++i) roller.step();
  double best = 1e9;
  for (int round = 0; round < 3; ++round) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < steps; ++i) roller.step();
    const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - start;
    best = std::min(best, elapsed.count() / steps);
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  const double amalia_us = microseconds("amalia", 20000);
  const double t0_r0_us = microseconds("t0_r0", 4000);
  std::printf("amalia_us %.1f t0_r0_us %.1f\n", amalia_us, t0_r0_us);
  return 0;
}
