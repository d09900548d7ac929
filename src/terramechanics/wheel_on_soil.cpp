#include "terramechanics/wheel_on_soil.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "terramechanics/ground_pressure.h"

namespace wheel_twin::terramechanics {
namespace {

constexpr double kLoadTolerance = 1e-10;  // of the load
constexpr int kMaximumSteps = 200;

RimMotion rim_motion(const Operation& operation) {
  const double s = operation.slip, beta = operation.steering_angle;
  if (!(s >= -1.0 && s <= 1.0)) throw Error(fmt::format("slip {:g} is outside -1 to 1", s));
  if (!(std::abs(beta) <= 1.5))
    throw Error(fmt::format("steering angle {:g} rad is outside -1.5 to 1.5", beta));
  const double travel = s >= 0.0 ? 1.0 - s : 1.0;
  return {s >= 0.0 ? 1.0 : 1.0 + s, travel * std::cos(beta), travel * std::sin(beta)};
}

}  // namespace

/// The vertical force of one operation as a function of sinkage and deflection.
struct WheelOnSoil::Vertical {
  const WheelOnSoil& model;
  ContactLaw law;
  double sinkage_factor;
  bool at_rest;
  Operation operation;
  RimMotion motion;
  double peak;

  ContactGeometry geometry(double z, double delta_d) const {
    return contact_geometry(model.wheel_.radius, z, delta_d, model.soil_.gamma, peak);
  }
  double force(double z, double delta_d) const {
    if (z <= 0.0) return 0.0;
    return at_rest ? static_vertical_force(geometry(z, delta_d), law)
                   : vertical_force(geometry(z, delta_d), motion, law);
  }
  std::string words() const {
    return at_rest ? "at rest"
                   : fmt::format("at slip {:g} and steering angle {:g} rad", operation.slip,
                                 operation.steering_angle);
  }
};

WheelOnSoil::WheelOnSoil(const Wheel& wheel, const Soil& soil)
    : wheel_(wheel), soil_(soil), k_eq_(sinkage_modulus(wheel, soil)) {
  if (!(wheel.radius > 0.0 && wheel.width > 0.0))
    throw Error(fmt::format("wheel '{}' has no size", wheel.name));
  if (!(soil.n > 0.0 && soil.n < 3.0))
    throw Error(fmt::format("soil '{}': n = {:g} is outside 0 to 3", soil.name, soil.n));
  if (!(soil.K > 0.0)) throw Error(fmt::format("soil '{}': K = {:g} m is not positive", soil.name, soil.K));
  if (!(soil.gamma >= 0.0 && soil.gamma <= 1.0)) {
    throw Error(fmt::format("soil '{}': gamma = {:g} is outside 0 to 1", soil.name, soil.gamma));
  }
}

ContactLaw WheelOnSoil::law(const SoilChange& change) const {
  if (!(change.sinkage_factor > 0.0))
    throw Error(fmt::format("sinkage factor {:g} is not positive", change.sinkage_factor));
  ContactLaw law;
  law.b = wheel_.width;
  law.k_eq = k_eq_;
  law.n = soil_.n;
  law.c = std::max(0.0, soil_.c + change.added_cohesion);
  law.tan_phi = std::tan(soil_.phi);
  law.K = soil_.K;
  law.weight_density = soil_.weight_density;
  law.grousers = wheel_.grousers;
  law.grouser_height = wheel_.grouser_height;
  law.factor = change.depth_factor;
  return law;
}

double WheelOnSoil::deflection_under(double load) const {
  if (!(load >= 0.0 && std::isfinite(load))) throw Error(fmt::format("load {:g} N is not a load", load));
  if (!wheel_.stiffness) return 0.0;
  const double delta_d = load / *wheel_.stiffness;
  if (!(delta_d < wheel_.radius)) {
    throw Error(fmt::format("wheel '{}': a load of {:g} N deflects it by {:g} m, beyond its radius",
                            wheel_.name, load, delta_d));
  }
  return delta_d;
}

ContactState WheelOnSoil::solve_load(double load, const Vertical& vertical, double sinkage_guess) const {
  const double R = wheel_.radius, n = soil_.n;
  const double delta_d = deflection_under(load);
  const double z_end = R - delta_d;
  double z = 0.0;
  if (load > 0.0) {
    // Bekker's closed form for normal stress alone, rigid and flat parts, as a first guess.
    z = sinkage_guess;
    if (!(z > 0.0 && z < z_end)) {
      const double patch = delta_d > 0.0 ? flat_patch_length(R, delta_d) : 0.0;
      const double arc =
          std::pow(3.0 * load / ((3.0 - n) * law({}).b * k_eq_ * std::sqrt(2.0 * R)), 2.0 / (2.0 * n + 1.0));
      z = arc;
      if (patch > 0.0) z = std::min(arc, std::pow(load / (wheel_.width * k_eq_ * patch), 1.0 / n));
      z = std::clamp(z, 1e-12 * R, 0.9 * z_end);
    }
    // The force rises from 0 with sinkage to one peak (or to the end) and the equilibrium lies on the rise.
    // `low` is on the rise below the load, `high` carries at least the load: between them the root is unique.
    double low = 0.0, force_low = 0.0, high = -1.0, force_high = 0.0;
    double force = vertical.force(z, delta_d);
    double best = force, best_z = z;
    const double growth = n + (delta_d > 0.0 ? 0.3 : 0.5);
    while (force < load) {
      if (z >= z_end || (low > 0.0 && force <= force_low)) break;
      low = z, force_low = force;
      const double step =
          force > 0.0 ? std::clamp(1.05 * std::pow(load / force, 1.0 / growth), 1.01, 4.0) : 1.5;
      z = std::min(z_end, z * step);
      force = vertical.force(z, delta_d);
      if (force > best) best = force, best_z = z;
    }
    if (force < load) {
      // Past the peak, or at the end without having reached the load: the peak lies in what has been passed.
      double a = 0.0, b = z;
      constexpr double kGolden = 0.6180339887498949;
      double x1 = b - kGolden * (b - a), x2 = a + kGolden * (b - a);
      double f1 = vertical.force(x1, delta_d), f2 = vertical.force(x2, delta_d);
      const auto note = [&](double x, double f) {
        if (f > best) best = f, best_z = x;
      };
      note(x1, f1), note(x2, f2);
      while (best < load && b - a > 1e-9 * R) {
        if (f1 < f2) {
          a = x1, x1 = x2, f1 = f2, x2 = a + kGolden * (b - a), f2 = vertical.force(x2, delta_d),
          note(x2, f2);
        } else {
          b = x2, x2 = x1, f2 = f1, x1 = b - kGolden * (b - a), f1 = vertical.force(x1, delta_d),
          note(x1, f1);
        }
      }
      if (best < load) {
        throw Error(fmt::format(
            "wheel '{}' on soil '{}' {}: no sinkage carries {:g} N, at most {:g} N at {:g} m", wheel_.name,
            soil_.name, vertical.words(), load, best, best_z * vertical.sinkage_factor));
      }
      z = best_z, force = best;
      low = 0.0, force_low = 0.0;
    }
    high = z, force_high = force;
    if (low <= 0.0) {  // a point on the rise below the load
      low = high, force_low = force_high;
      while (force_low >= load) {
        high = low, force_high = force_low;
        const double step = std::clamp(0.95 * std::pow(load / force_low, 1.0 / growth), 1e-3, 0.95);
        low = low * step;
        force_low = vertical.force(low, delta_d);
      }
    }
    // Secant in the logarithms (a power law is a straight line there) inside the bracket, halved when it
    // lags.
    double x0 = low, f0 = force_low, x1 = high, f1 = force_high;
    z = std::abs(f1 - load) < std::abs(f0 - load) ? x1 : x0;
    force = z == x1 ? f1 : f0;
    double width = std::log(high / low);
    for (int i = 0; i < kMaximumSteps && std::abs(force - load) > kLoadTolerance * load; ++i) {
      double next = std::sqrt(low * high);
      if (f0 > 0.0 && f1 > 0.0 && f0 != f1) {
        const double guess = z * std::exp(std::log(load / force) * std::log(x1 / x0) / std::log(f1 / f0));
        const double now = std::log(high / low);
        if (guess > low && guess < high && (i < 3 || now < 0.6 * width || i % 3 != 0)) next = guess;
        if (i % 3 == 0) width = now;
      }
      if (!(next > low && next < high)) break;  // the bracket is one rounding wide
      x0 = z, f0 = force;
      z = next;
      force = vertical.force(z, delta_d);
      x1 = z, f1 = force;
      (force < load ? low : high) = z;
    }
  }
  ContactState state;
  state.sinkage = z * vertical.sinkage_factor;
  state.deflection = delta_d;
  fill_loads(state, vertical);
  return state;
}

ContactState WheelOnSoil::solve_displacement(double h, const Vertical& vertical,
                                             double deflection_guess) const {
  if (!(h <= wheel_.radius)) {
    throw Error(fmt::format(
        "wheel '{}' on soil '{}': the hub is {:g} m below its height at first touch, the radius is {:g} m",
        wheel_.name, soil_.name, h, wheel_.radius));
  }
  ContactState state;
  state.hub_displacement = h;
  if (h <= 0.0) return state;
  double delta_d = 0.0;
  if (wheel_.stiffness) {
    // Soil force less wheel force falls with the deflection: from the rigid wheel's force to -k h.
    const double k = *wheel_.stiffness;
    const auto excess = [&](double d) {
      return vertical.force((h - d) / vertical.sinkage_factor, d) - k * d;
    };
    double low = 0.0, high = h;
    double d0 = deflection_guess, f0 = 0.0;
    if (!(d0 > 0.0 && d0 < h)) d0 = std::min(0.5 * h, vertical.force(h / vertical.sinkage_factor, 0.0) / k);
    if (d0 > 0.0) {
      f0 = excess(d0);
      (f0 > 0.0 ? low : high) = d0;
      double slope = -2.0 * k;
      double d1 = d0, f1 = f0;
      const double tolerance = kLoadTolerance * k * h;
      for (int i = 0; i < kMaximumSteps && std::abs(f1) > tolerance; ++i) {
        double next = d1 - f1 / slope;
        if (!(next > low && next < high) || i % 6 == 5) next = 0.5 * (low + high);
        if (!(next > low && next < high)) break;
        const double f = excess(next);
        if (next != d1 && f != f1) slope = std::min((f - f1) / (next - d1), -0.1 * k);
        d1 = next, f1 = f;
        (f1 > 0.0 ? low : high) = d1;
      }
      delta_d = d1;
    }
  }
  state.deflection = delta_d;
  state.sinkage = h - delta_d;
  fill_loads(state, vertical);
  return state;
}

void WheelOnSoil::fill_loads(ContactState& state, const Vertical& vertical) const {
  const ContactGeometry g = vertical.geometry(state.sinkage / vertical.sinkage_factor, state.deflection);
  state.hub_displacement = state.sinkage + state.deflection;
  state.entry_angle = g.theta_1;
  state.exit_angle = vertical.at_rest ? -g.theta_1 : g.theta_2;
  state.deflection_angle = g.theta_d;
  state.peak_angle = vertical.at_rest ? 0.0 : g.theta_m;
  if (g.z <= 0.0) return;
  state.grousers_in_soil = wheel_.grousers *
                           (g.front - (vertical.at_rest ? -g.front : -g.rear) + 2.0 * std::sin(g.theta_d)) /
                           (2.0 * M_PI);
  if (vertical.at_rest) {
    state.normal_load = static_vertical_force(g, vertical.law);
    return;
  }
  const ContactLoads loads = contact_loads(g, vertical.motion, vertical.law);
  state.normal_load = loads.vertical;
  state.thrust = loads.thrust;
  state.grouser_thrust = loads.grouser_thrust;
  state.compaction_resistance = loads.compaction_resistance;
  state.bulldozing_force = loads.bulldozing;
  state.flexing_resistance = vertical.motion.rolling > 0.0 ? wheel_.flexing_resistance : 0.0;
  state.drive_torque = loads.torque;
  const double along =
      loads.thrust + loads.grouser_thrust - loads.compaction_resistance - state.flexing_resistance;
  const double across = loads.side_shear + loads.bulldozing;
  const double cos_b = std::cos(vertical.operation.steering_angle),
               sin_b = std::sin(vertical.operation.steering_angle);
  state.drawbar_pull = along * cos_b - across * sin_b;
  state.side_force = along * sin_b + across * cos_b;
  state.torque_x = loads.moment_x * cos_b + loads.torque * sin_b;
  state.torque_y = loads.moment_x * sin_b - loads.torque * cos_b;
  state.torque_z = loads.moment_z;
}

WheelOnSoil::Vertical WheelOnSoil::rolling(const Operation& operation, const SoilChange& change) const {
  const double peak = std::clamp(soil_.c1 + soil_.c2 * std::abs(operation.slip), 0.0, 1.0);
  return {*this, law(change), change.sinkage_factor, false, operation, rim_motion(operation), peak};
}

WheelOnSoil::Vertical WheelOnSoil::resting(const SoilChange& change) const {
  return {*this, law(change), change.sinkage_factor, true, {}, {}, 0.0};
}

ContactState WheelOnSoil::at_load(double load, const Operation& operation, const SoilChange& change,
                                  double sinkage_guess) const {
  return solve_load(load, rolling(operation, change), sinkage_guess / change.sinkage_factor);
}

ContactState WheelOnSoil::at_rest_under_load(double load, const SoilChange& change) const {
  return solve_load(load, resting(change), 0.0);
}

ContactState WheelOnSoil::at_hub_displacement(double hub_displacement, const Operation& operation,
                                              const SoilChange& change, double deflection_guess) const {
  return solve_displacement(hub_displacement, rolling(operation, change), deflection_guess);
}

ContactState WheelOnSoil::at_rest_at_hub_displacement(double hub_displacement, const SoilChange& change,
                                                      double deflection_guess) const {
  return solve_displacement(hub_displacement, resting(change), deflection_guess);
}

double WheelOnSoil::vertical_stiffness(const ContactState& state, const Operation& operation,
                                       const SoilChange& change) const {
  return stiffness(state, rolling(operation, change));
}

double WheelOnSoil::vertical_stiffness_at_rest(const ContactState& state, const SoilChange& change) const {
  return stiffness(state, resting(change));
}

double WheelOnSoil::stiffness(const ContactState& state, const Vertical& vertical) const {
  if (state.hub_displacement <= 0.0) return 0.0;
  const double z = state.sinkage / vertical.sinkage_factor, delta_d = state.deflection;
  const double step = 1e-5 * z;
  const double force = vertical.force(z, delta_d);
  const double by_sinkage = (force - vertical.force(z - step, delta_d)) / (step * vertical.sinkage_factor);
  if (!wheel_.stiffness) return by_sinkage;
  // k d(delta) = F_z (dh - d(delta)) + F_delta d(delta)
  const double bend = 1e-5 * std::max(delta_d, 1e-9);
  const double by_deflection = (force - vertical.force(z, std::max(0.0, delta_d - bend))) / bend;
  const double k = *wheel_.stiffness;
  return k * by_sinkage / (k + by_sinkage - by_deflection);
}

double WheelOnSoil::towed_slip(double load, double steering_angle, const SoilChange& change) const {
  double sinkage = 0.0;
  const auto torque = [&](double s) {
    const ContactState state = at_load(load, {s, steering_angle}, change, sinkage);
    sinkage = state.sinkage;
    return state.drive_torque;
  };
  double high = 0.0, t_high = torque(high);
  double low = high, t_low = t_high;
  for (double step = 0.02; t_high < 0.0 && high < 1.0; step *= 2.0) {
    low = high, t_low = t_high;
    high = std::min(1.0, high + step);
    t_high = torque(high);
  }
  for (double step = 0.02; t_low > 0.0 && low > -1.0; step *= 2.0) {
    high = low, t_high = t_low;
    low = std::max(-1.0, low - step);
    t_low = torque(low);
  }
  if (!(t_low <= 0.0 && t_high >= 0.0)) {
    throw Error(fmt::format("wheel '{}' on soil '{}': no slip turns the towed wheel under {:g} N",
                            wheel_.name, soil_.name, load));
  }
  // Regula falsi with the Illinois rule.
  const double tolerance = 1e-9 * load * wheel_.radius;
  int side = 0;
  for (int i = 0; i < kMaximumSteps; ++i) {
    if (t_high == t_low) return low;
    const double s = (low * t_high - high * t_low) / (t_high - t_low);
    const double t = torque(s);
    if (std::abs(t) <= tolerance || high - low < 1e-15) return s;
    if (t < 0.0) {
      low = s, t_low = t;
      if (side == -1) t_high *= 0.5;
      side = -1;
    } else {
      high = s, t_high = t;
      if (side == 1) t_low *= 0.5;
      side = 1;
    }
  }
  return 0.5 * (low + high);
}

ContactState predict_steady_state(const Wheel& wheel, const Soil& soil, double load,
                                  const Operation& operation, const SoilChange& change) {
  return WheelOnSoil(wheel, soil).at_load(load, operation, change);
}

}  // namespace wheel_twin::terramechanics
