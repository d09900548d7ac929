#include "cases.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "base/error.h"

namespace wheel_twin::wheel {

using Eigen::Vector3d;

WheelModel configured_wheel(const std::string& name, Bending rim_bending, int segments) {
  WheelModel model = read_wheel_file(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels/" + name + ".yaml");
  model.segments = segments;
  model.bending = rim_bending;
  model.grousers = 0;
  const double rigidity = model.rim.flexural_rigidity();
  model.rim_joint_stiffness =
      rim_bending == Bending::printed
          ? printed_stiffness(segments, model.radius, rigidity, small_load(model.radius, rigidity))
          : bending_stiffness(model.rim, rim_bending, 2.0 * M_PI * model.radius / segments);
  return model;
}

double measured_frequency(const WheelModel& ring, int n) {
  FlexibleWheel wheel(ring);
  const double dt = std::min(2.0e-5, wheel.stable_step());
  const double rest = wheel.segment(0).position.norm();
  const double impulse = 1.0e-6 * ring.radius * wheel.rim_mass() / ring.segments / dt * 100.0;
  for (int i = 0; i < ring.segments; ++i) {
    const double angle = 2.0 * M_PI * i / ring.segments;
    const double force = impulse * std::cos(n * angle);
    wheel.apply(i, {force * std::sin(angle), 0.0, force * std::cos(angle)}, Vector3d::Zero());
  }
  double first = 0.0, last = 0.0, before = 0.0;
  int crossings = 0;
  for (int step = 1; crossings < 21; ++step) {
    wheel.step(dt, {});
    const double now = wheel.segment(0).position.norm() - rest;
    if (step > 2 && before * now < 0.0) {
      last = dt * (step - now / (now - before));
      if (crossings == 0) first = last;
      ++crossings;
    }
    before = now;
    if (step > 100000000) throw Error("the ring does not vibrate");
  }
  return M_PI * (crossings - 1) / (last - first);
}

Rolling roll(const WheelModel& model, double load, double speed, double settle, double distance,
             double floor_damping) {
  RollingSettings settings;
  settings.load = load;
  settings.speed = speed;
  settings.ramp = 0.5 * settle / speed;
  settings.ground.contact = {5.0e5, floor_damping, 0.8};
  RollingWheel rolling_wheel(model, settings);
  rolling_wheel.settle();
  Rolling rolling;
  double start_energy = 0.0;
  const double dt = rolling_wheel.time_step();
  const auto every = std::max<std::int64_t>(1, std::llround((settle + distance) / speed / dt / 8000.0));
  for (std::int64_t i = 0;; ++i) {
    rolling_wheel.step();
    const HubMotion hub = rolling_wheel.wheel().hub();
    if (hub.position.x() >= settle + distance) break;
    const double dissipated = rolling_wheel.wheel().energy().dissipated;
    if (hub.position.x() < settle) {
      start_energy = dissipated;
      continue;
    }
    rolling.dissipated = dissipated - start_energy;
    if (i % every != 0) continue;
    const Vector3d force = rolling_wheel.ground_force();
    rolling.samples.push_back({hub.position.x(), hub.position.z(), force.x(), force.z(), hub.angle});
  }
  return rolling;
}

Rolling roll_without_bounce(int segments) {
  WheelModel model = configured_wheel("amalia", Bending::plate, segments);
  model.hub_mass = 0.05;
  return roll(model, 42.1, 0.05, 0.05, 2.5 * 2.0 * M_PI * model.radius / 16.0, 5.0);
}

RollingMeans means(const Rolling& rolling) {
  RollingMeans mean;
  const auto& samples = rolling.samples;
  const auto n = static_cast<double>(samples.size());
  for (const RollingSample& sample : samples) {
    mean.hub_height += sample.hub_height / n;
    mean.thrust += sample.thrust / n;
  }
  const double distance = samples.back().distance - samples.front().distance;
  mean.resistance = rolling.dissipated / distance;
  mean.radius = distance / (samples.back().angle - samples.front().angle);
  return mean;
}

double ripple(const Rolling& rolling, double per_revolution) {
  // Whole periods only, and no mean, so that neither leaks into the harmonic.
  const double period = 2.0 * M_PI / per_revolution;
  const double start = rolling.samples.front().angle;
  const double end = start + period * std::floor((rolling.samples.back().angle - start) / period);
  const double mean = means(rolling).hub_height;
  double c = 0.0, s = 0.0;
  for (std::size_t i = 1; i < rolling.samples.size() && rolling.samples[i].angle <= end; ++i) {
    const RollingSample& sample = rolling.samples[i];
    const double weight = sample.angle - rolling.samples[i - 1].angle;
    c += weight * (sample.hub_height - mean) * std::cos(per_revolution * sample.angle);
    s += weight * (sample.hub_height - mean) * std::sin(per_revolution * sample.angle);
  }
  return 2.0 * std::hypot(c, s) / (end - start);
}

double height_at(const Rolling& rolling, double angle, double half_window) {
  double sum = 0.0;
  int count = 0;
  for (const RollingSample& sample : rolling.samples) {
    if (std::abs(std::remainder(sample.angle - angle, 2.0 * M_PI)) > half_window) continue;
    sum += sample.hub_height;
    ++count;
  }
  if (count == 0) throw Error("the wheel did not pass this angle");
  return sum / count;
}

void strike(FlexibleWheel& wheel, double dt) {
  HubMotion hub;
  hub.rate = 10.0;
  hub.velocity = {0.05, 0.0, 0.02};
  wheel.place(hub);
  wheel.set_freedom({true, true, true});
  for (int i = 0; i < 200; ++i) {
    wheel.apply(5, {0.0, 0.0, 12.0}, Vector3d::Zero());
    wheel.apply(37, {2.0, 0.0, 0.0}, {0.0, 0.02, 0.0});
    wheel.step(dt, {});
  }
  wheel.step(dt, {});  // the last force ends within this step
}

Drift free_spin(FlexibleWheel& wheel, double dt, double seconds) {
  strike(wheel, dt);
  const auto energy = [&] { return wheel.energy().kinetic + wheel.energy().elastic; };
  const double L = wheel.angular_momentum(), E = energy();
  Drift drift;
  drift.elastic_share = wheel.energy().elastic / E;
  const auto steps = static_cast<int>(seconds / dt);
  for (int i = 0; i < steps; ++i) {
    wheel.step(dt, {});
    if (i % 50 != 0) continue;
    drift.momentum = std::max(drift.momentum, std::abs(wheel.angular_momentum() / L - 1.0));
    drift.energy = std::max(drift.energy, std::abs(energy() / E - 1.0));
  }
  return drift;
}

double finite_element_drop(const std::string& name, double load) {
  const std::string path =
      std::string(WHEEL_TWIN_SOURCE_DIR) + "/test/verification/wheel/reference/" + name + ".csv";
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  double drop = 0.0, force = 0.0, drop_before = 0.0, force_before = 0.0;
  char comma = 0;
  while (file >> drop >> comma >> force) {
    if (force >= load)
      return drop_before + (drop - drop_before) * (load - force_before) / (force - force_before);
    drop_before = drop;
    force_before = force;
  }
  throw Error(path + ": does not reach the load");
}

namespace {

/// Heights over angles (degrees) of one curve of reference/beam_model_height.csv.
std::map<double, double> beam_model_curve(const std::string& wheel, bool missing) {
  const std::string path =
      std::string(WHEEL_TWIN_SOURCE_DIR) + "/test/verification/wheel/reference/beam_model_height.csv";
  std::ifstream file(path);
  std::map<double, double> curve;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::string name, without, load, angle, height;
    std::getline(cells, name, ',');
    std::getline(cells, without, ',');
    std::getline(cells, load, ',');
    std::getline(cells, angle, ',');
    std::getline(cells, height, ',');
    if (name == wheel && without.empty() != missing) curve[std::stod(angle)] = std::stod(height);
  }
  if (curve.empty()) throw Error(path + ": no curve of " + wheel);
  return curve;
}

}  // namespace

double beam_model_height(const std::string& wheel, bool missing, double degrees) {
  return beam_model_curve(wheel, missing).at(degrees);
}

double beam_model_mean(const std::string& wheel, bool missing) {
  // Half a turn or a whole pitch, its two ends half weighted.
  const auto curve = beam_model_curve(wheel, missing);
  double sum = 0.5 * (curve.begin()->second + curve.rbegin()->second);
  for (auto it = std::next(curve.begin()); std::next(it) != curve.end(); ++it) sum += it->second;
  return sum / static_cast<double>(curve.size() - 1);
}

double beam_model_ripple(const std::string& wheel, int n) {
  const auto curve = beam_model_curve(wheel, true);
  const double last = curve.rbegin()->first;  // half a turn of an even function
  double sum = 0.0;
  for (const auto& [degrees, height] : curve) {
    const double weight = degrees == 0.0 || degrees == last ? 0.5 : 1.0;
    sum += weight * height * std::cos(n * degrees * M_PI / 180.0);
  }
  return std::abs(2.0 * sum / static_cast<double>(curve.size() - 1));
}

WheelModel plate_wheel(const std::string& name, int segments) {
  WheelModel model = configured_wheel(name, Bending::plate, segments);
  if (model.suspension == Suspension::beams) {
    const double radius = 0.5 * (model.radius - model.hub_radius);
    model.beams.joint_stiffness =
        bending_stiffness(model.beams.sheet, Bending::plate, M_PI * radius / model.beams.bodies);
  }
  return model;
}

bool long_run() {
  return std::getenv("WHEEL_TWIN_LONG") != nullptr;
}

}  // namespace wheel_twin::wheel
