// The numbers behind the wheel's plots (scripts/plots/wheel), as JSON: convergence of the ring, height,
// ripple and rolling resistance of wheels that roll on a hard floor, ten seconds of free spin.
//   wheel_study convergence | ripple | resistance | rolling WHEEL RULE | spin WHEEL SECONDS
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "cases.h"

namespace wheel_twin::wheel {
namespace {

using nlohmann::json;

constexpr const char* kUsage =
    "wheel_study convergence | ripple | resistance | rolling WHEEL plate|configured | missing WHEEL | spin "
    "WHEEL "
    "SECONDS";
constexpr double kAmaliaLoad = 42.1, kT0R0Load = 81.75;  // N, of the paper

double pitch_of(const WheelModel& model) {
  return 2.0 * M_PI * model.radius / 16.0;
}

json convergence() {
  json result;
  for (const char* name : {"amalia", "t0_r0"}) {
    for (const int segments : {32, 64, 128, 256}) {
      const WheelModel ring = free_ring(configured_wheel(name, Bending::beam, segments));
      const double rigidity = ring.rim.flexural_rigidity();
      const double load = elastica_load(ring.radius, rigidity, 0.05);
      const double error = squeeze(ring, load).loaded / elastica(ring.radius, rigidity, load).loaded - 1.0;
      result[name].push_back({{"segments", segments}, {"error", error}});
    }
  }
  return result;
}

/// Amplitudes of the hub height of the rolling AMALIA, of the segments' harmonic and of the spring
/// positions'.
json ripples() {
  json result = json::array();
  for (const int segments : {32, 48, 64, 96, 128}) {
    const Rolling rolling = roll_without_bounce(segments);
    result.push_back({{"segments", segments},
                      {"of_segments_m", ripple(rolling, segments)},
                      {"of_positions_m", ripple(rolling, 16.0)}});
  }
  return result;
}

json resistances() {
  json result = json::array();
  for (const double ratio : {0.0, 0.005, 0.01, 0.02, 0.04, 0.08}) {
    WheelModel model = configured_wheel("amalia", Bending::plate);
    model.damping_ratio = ratio;
    const RollingMeans mean = means(roll(model, kAmaliaLoad, 0.1, 0.05, 2.5 * pitch_of(model), 5.0));
    result.push_back(
        {{"damping_ratio", ratio}, {"resistance_n", mean.resistance}, {"thrust_n", mean.thrust}});
  }
  return result;
}

json rolling(const std::string& name, const std::string& rule) {
  const bool plate = rule == "plate";
  if (!plate && rule != "configured") throw Error("the rule is plate or configured, not " + rule);
  const WheelModel model = plate ? plate_wheel(name) : configured_wheel(name, Bending::printed);
  const double load = name == "amalia" ? kAmaliaLoad : kT0R0Load;
  const double pitch = pitch_of(model);
  const Rolling run = roll(model, load, 0.15, 0.5 * pitch, pitch, 20.0);
  const RollingMeans mean = means(run);
  const double undeformed = model.radius + 0.5 * model.rim.thickness;
  const double reference = undeformed - beam_model_mean(name, false);
  json samples = json::array();
  const std::size_t every = std::max<std::size_t>(1, run.samples.size() / 200);
  for (std::size_t i = 0; i < run.samples.size(); i += every)
    samples.push_back({run.samples[i].distance, undeformed - run.samples[i].hub_height});
  return {{"wheel", name},
          {"rule", rule},
          {"load_n", load},
          {"mean_drop_m", undeformed - mean.hub_height},
          {"reference_drop_m", reference},
          {"difference", (undeformed - mean.hub_height) / reference - 1.0},
          {"thrust_over_load", mean.thrust / load},
          {"samples", samples}};
}

/// A turn of a wheel without the springs or beams of position 8, which is lowest when the wheel's angle is 0.
json missing(const std::string& name) {
  WheelModel model = plate_wheel(name);
  model.faults = {{8, 0, 0.0}, {8, 1, 0.0}};
  model.hub_mass = 0.05;  // a light hub bounces little
  const double load = name == "amalia" ? kAmaliaLoad : kT0R0Load;
  const Rolling run = roll(model, load, 0.05, 0.5 * pitch_of(model), 2.04 * M_PI * model.radius, 20.0);
  const double undeformed = model.radius + 0.5 * model.rim.thickness;
  json samples = json::array();
  const std::size_t every = std::max<std::size_t>(1, run.samples.size() / 1000);
  for (std::size_t i = 0; i < run.samples.size(); i += every)
    samples.push_back({run.samples[i].angle, undeformed - run.samples[i].hub_height});
  return {{"wheel", name},
          {"first_harmonic_m", ripple(run, 1.0)},
          {"first_harmonic_reference_m", beam_model_ripple(name, 1)},
          {"samples", samples}};
}

json spin(const std::string& name, double seconds) {
  WheelModel model = configured_wheel(name, Bending::beam);
  model.damping_ratio = 0.0;
  FlexibleWheel wheel(model);
  const Drift drift = free_spin(wheel, 2e-5, seconds);
  return {{"wheel", name},
          {"seconds", seconds},
          {"angular_momentum", drift.momentum},
          {"energy", drift.energy},
          {"elastic_share", drift.elastic_share}};
}

json study(const std::vector<std::string>& arguments) {
  const std::string what = arguments.empty() ? "" : arguments[0];
  if (what == "convergence") return convergence();
  if (what == "ripple") return ripples();
  if (what == "resistance") return resistances();
  if (what == "rolling" && arguments.size() == 3) return rolling(arguments[1], arguments[2]);
  if (what == "missing" && arguments.size() == 2) return missing(arguments[1]);
  if (what == "spin" && arguments.size() == 3) return spin(arguments[1], std::stod(arguments[2]));
  throw Error(
      "usage: wheel_study convergence | ripple | resistance | rolling WHEEL RULE | spin WHEEL SECONDS");
}

}  // namespace
}  // namespace wheel_twin::wheel

int main(int argc, char** argv) {
  try {
    fmt::print("{}\n", wheel_twin::wheel::study({argv + 1, argv + argc}).dump(1));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "wheel_study: {}\n", error.what());
    return 2;
  }
}
