#include "cases.h"

#include <algorithm>
#include <cmath>
#include <fstream>

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

WheelModel free_ring(const WheelModel& wheel) {
  WheelModel ring = wheel;
  ring.suspension = Suspension::springs;
  ring.springs.positions = 0;
  ring.faults.clear();
  ring.damping_ratio = 0.0;
  return ring;
}

namespace {

struct Quarter {
  double end_angle, x, y;
};

Quarter integrate(double curvature, double k, double length) {
  const int steps = 4000;
  const double h = length / steps;
  double psi = 0.0, kappa = curvature, x = 0.0, y = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double k1 = kappa, l1 = -k * std::sin(psi);
    const double k2 = kappa + 0.5 * h * l1, l2 = -k * std::sin(psi + 0.5 * h * k1);
    const double k3 = kappa + 0.5 * h * l2, l3 = -k * std::sin(psi + 0.5 * h * k2);
    const double k4 = kappa + h * l3, l4 = -k * std::sin(psi + h * k3);
    const double middle = psi + 0.25 * h * (k1 + k2);
    const double next = psi + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    x += h / 6.0 * (std::sin(psi) + 4.0 * std::sin(middle) + std::sin(next));
    y += h / 6.0 * (std::cos(psi) + 4.0 * std::cos(middle) + std::cos(next));
    psi = next;
    kappa += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
  }
  return {psi, x, y};
}

}  // namespace

DiameterChange elastica(double radius, double flexural_rigidity, double load) {
  const double k = 0.5 * load / flexural_rigidity;
  const double length = 0.5 * M_PI * radius;
  double low = 0.0;
  double high = 10.0 / radius;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (integrate(middle, k, length).end_angle < 0.5 * M_PI ? low : high) = middle;
  }
  const Quarter quarter = integrate(0.5 * (low + high), k, length);
  return {2.0 * (quarter.y - radius), 2.0 * (quarter.x - radius)};
}

double elastica_load(double radius, double flexural_rigidity, double fraction) {
  double low = 0.0;
  double high = 4.0 * fraction * 2.0 * flexural_rigidity / (0.1488 * radius * radius);
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (-elastica(radius, flexural_rigidity, middle).loaded < fraction * 2.0 * radius ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

DiameterChange squeeze(const WheelModel& ring, double load) {
  FlexibleWheel wheel(ring);
  const int half = ring.segments / 2;
  const int quarter = ring.segments / 4;
  const auto span = [&](int a, int b) {
    return (wheel.segment(a).position - wheel.segment(b).position).norm();
  };
  const double loaded = span(0, half);
  const double free = span(quarter, quarter + half);
  const double omega = ring_frequency(2, ring.radius, ring.rim.flexural_rigidity(),
                                      ring.rim.density * ring.rim.width * ring.rim.thickness);
  wheel.relax(wheel.stable_step(), 2.0 * omega, 1.0e-7, 2000000, [&](FlexibleWheel& w) {
    w.apply(0, {0.0, 0.0, -load}, Vector3d::Zero());
    w.apply(half, {0.0, 0.0, load}, Vector3d::Zero());
  });
  return {span(0, half) - loaded, span(quarter, quarter + half) - free};
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

double standing_deflection(const WheelModel& model, double load, double angle) {
  FlexibleWheel wheel(model);
  HubMotion hub;
  hub.angle = angle;
  wheel.place(hub);
  const double touch = -RigidFloor::lowest_corner(wheel);
  hub.position.z() = touch;
  wheel.place(hub);
  wheel.set_freedom({false, true, false});
  wheel.set_hub_load({{0.0, 0.0, -load}, Vector3d::Zero()});
  RigidFloor floor(wheel, {0.0, 1.0e6, 0.0, 0.0});
  const double dt = std::min(1.0e-5, wheel.stable_step());
  wheel.relax(dt, 150.0, 1.0e-7, 500000, [&](FlexibleWheel& w) { floor.press(w, dt); });
  const double overlap = -RigidFloor::lowest_corner(wheel);
  return touch - wheel.hub().position.z() - overlap;
}

Rolling roll(const WheelModel& model, double load, double speed, double settle, double distance,
             double floor_damping) {
  FlexibleWheel wheel(model);
  HubMotion hub;
  hub.position.z() = -RigidFloor::lowest_corner(wheel);
  wheel.place(hub);
  wheel.set_freedom({false, true, false});
  wheel.set_hub_load({{0.0, 0.0, -load}, Vector3d::Zero()});
  RigidFloor floor(wheel, {0.0, 5.0e5, floor_damping, 0.8});
  const double dt = std::min(2.0e-5, wheel.stable_step());
  wheel.relax(dt, 150.0, 1.0e-5, 500000, [&](FlexibleWheel& w) { floor.press(w, dt); });
  hub = wheel.hub();
  wheel.set_freedom({false, true, true});
  // Brought to speed over a quarter of the settling distance, without a jump of the acceleration.
  const double ramp = 0.5 * settle / speed;
  Rolling rolling;
  double time = 0.0, start_energy = 0.0;
  const double end = 0.5 * ramp + (settle + distance) / speed;
  const auto samples = static_cast<std::int64_t>(end / dt);
  const std::int64_t every = std::max<std::int64_t>(1, samples / 8000);
  for (std::int64_t i = 0; i < samples; ++i) {
    const Vector3d force = floor.press(wheel, dt);
    time += dt;
    const double s = std::min(1.0, time / ramp);
    hub.velocity.x() = speed * s * s * (3.0 - 2.0 * s);
    hub.position.x() =
        speed * (s < 1.0 ? ramp * (s * s * s - 0.5 * s * s * s * s) : 0.5 * ramp + (time - ramp));
    wheel.step(dt, hub);
    if (hub.position.x() < settle) {
      start_energy = wheel.energy().dissipated;
      continue;
    }
    rolling.dissipated = wheel.energy().dissipated - start_energy;
    const HubMotion now = wheel.hub();
    if (i % every == 0)
      rolling.samples.push_back({hub.position.x(), now.position.z(), force.x(), force.z(), now.angle});
  }
  return rolling;
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

double finite_element_drop(const std::string& name, double load) {
  const std::string path =
      std::string(WHEEL_TWIN_SOURCE_DIR) + "/test/verification/wheel/calculix/reference/" + name + ".csv";
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

}  // namespace wheel_twin::wheel
