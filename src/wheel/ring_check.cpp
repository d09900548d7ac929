#include "wheel/ring_check.h"

#include <cmath>

#include "wheel/flexible_wheel.h"

namespace wheel_twin::wheel {

using Eigen::Vector3d;

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

WheelModel free_ring(const WheelModel& wheel) {
  WheelModel ring = wheel;
  ring.suspension = Suspension::springs;
  ring.springs.positions = 0;
  ring.faults.clear();
  ring.damping_ratio = 0.0;
  return ring;
}

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

}  // namespace wheel_twin::wheel
