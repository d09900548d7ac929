#include "terramechanics/wheel_on_soil.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "terramechanics/first_crossing.h"
#include "terramechanics/ground_pressure.h"

namespace wheel_twin::terramechanics {
namespace {

constexpr double kLoadTolerance = 1e-10;  // of the load
constexpr double kShareTolerance = 1e-9;  // of the load, between wheel and soil
constexpr double kTableShareTolerance = 1e-7;
constexpr int kMaximumSteps = 200;

RimMotion checked_motion(const Operation& operation) {
  const double s = operation.slip, beta = operation.steering_angle;
  if (!(s >= -1.0 && s <= 1.0)) throw Error(fmt::format("slip {:g} is outside -1 to 1", s));
  if (!(std::abs(beta) <= 1.5))
    throw Error(fmt::format("steering angle {:g} rad is outside -1.5 to 1.5", beta));
  return rim_motion(s, beta);
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
    if (tabulated(z, delta_d))
      return at_rest ? model.table_->at_rest(z, delta_d, law)
                     : model.table_->vertical(z, delta_d, operation.slip, law);
    return at_rest ? static_vertical_force(geometry(z, delta_d), law)
                   : vertical_force(geometry(z, delta_d), motion, law);
  }
  ContactLoads loads(const ContactGeometry& g) const {
    return tabulated(g.z, g.delta_d) ? model.table_->loads(g.z, g.delta_d, operation.slip, law)
                                     : contact_loads(g, motion, law);
  }
  bool tabulated(double z, double delta_d) const {
    return model.table_ && law.factor == nullptr && operation.steering_angle == 0.0 &&
           model.table_->covers(z, delta_d, operation.slip);
  }
  std::string words() const {
    return at_rest ? "at rest"
                   : fmt::format("at slip {:g} and steering angle {:g} rad", operation.slip,
                                 operation.steering_angle);
  }
};

WheelOnSoil::WheelOnSoil(const Wheel& wheel, const Soil& soil, std::shared_ptr<const ContactTable> table)
    : wheel_(wheel), soil_(soil), k_eq_(sinkage_modulus(wheel, soil)), table_(std::move(table)) {
  if (table_ && !table_->fits(wheel, soil)) table_ = nullptr;
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
  if (!(change.stiffness_factor > 0.0))
    throw Error(fmt::format("stiffness factor {:g} is not positive", change.stiffness_factor));
  ContactLaw law;
  law.b = wheel_.width;
  law.k_eq = k_eq_ * change.stiffness_factor;
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

double WheelOnSoil::guess_sinkage(double load, double delta_d) const {
  // Bekker's closed forms for normal stress alone: arcs of a rigid wheel, or the flat patch.
  const double R = wheel_.radius, n = soil_.n;
  double z =
      std::pow(3.0 * load / ((3.0 - n) * wheel_.width * k_eq_ * std::sqrt(2.0 * R)), 2.0 / (2.0 * n + 1.0));
  if (delta_d > 0.0) {
    z = std::min(z, std::pow(load / (wheel_.width * k_eq_ * flat_patch_length(R, delta_d)), 1.0 / n));
  }
  return z;
}

ContactState WheelOnSoil::solve_load(double load, const Vertical& vertical, double sinkage_guess) const {
  const double delta_d = deflection_under(load);
  const double z_end = wheel_.radius - delta_d;
  double z = 0.0;
  if (load > 0.0) {
    const double guess = sinkage_guess > 0.0 ? sinkage_guess : guess_sinkage(load, delta_d);
    const auto force = [&](double sinkage) { return vertical.force(sinkage, delta_d); };
    const double growth = soil_.n + (delta_d > 0.0 ? 0.3 : 0.5);
    // Cohesion can carry a load of its own before the pressure does where that starts more slowly.
    const bool cohesive = !vertical.at_rest && vertical.law.c > 0.0 && soil_.n > 1.0 &&
                          load < 3.0 * vertical.law.c * wheel_.width * (delta_d + guess);
    const Crossing crossing =
        FirstCrossing(force, load, z_end, growth)
            .find(std::clamp(guess, 1e-14 * wheel_.radius, 0.9 * z_end), cohesive, kLoadTolerance);
    if (!crossing.found) {
      throw Error(
          fmt::format("wheel '{}' on soil '{}' {}: no sinkage carries {:g} N, at most {:g} N at {:g} m",
                      wheel_.name, soil_.name, vertical.words(), load, crossing.best_force,
                      crossing.best_x * vertical.sinkage_factor));
    }
    z = crossing.x;
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
  state.sinkage = wheel_.stiffness ? share_displacement(h, vertical, deflection_guess) : h;
  state.deflection = h - state.sinkage;
  fill_loads(state, vertical);
  return state;
}

double WheelOnSoil::share_displacement(double h, const Vertical& vertical, double deflection_guess) const {
  // The ratio of what the soil carries to what the wheel carries goes from 0 to infinity as the sinkage z
  // goes from 0 to h. Its logarithm is nearly linear in y = log(z / (h - z)), stiff soil or soft.
  const double k = *wheel_.stiffness;
  const auto sinkage = [&](double y) { return h / (1.0 + std::exp(-y)); };
  const auto log_ratio = [&](double y) {
    const double deflection = h / (1.0 + std::exp(y));
    const double force = vertical.force(sinkage(y) / vertical.sinkage_factor, deflection);
    return force > 0.0 ? std::log(force / (k * deflection)) : -HUGE_VAL;
  };
  double low = -60.0, high = 34.0;  // e^34: the deflection is beneath rounding
  double y = deflection_guess > 0.0 && deflection_guess < h
                 ? std::log((h - deflection_guess) / deflection_guess)
                 : 0.0;
  double slope = vertical.at_rest ? soil_.n + 0.7 : soil_.n + 0.5;
  double f = log_ratio(y);
  const double tolerance = table_ ? kTableShareTolerance : kShareTolerance;
  for (int i = 0; i < kMaximumSteps && std::abs(f) > tolerance; ++i) {
    (f < 0.0 ? low : high) = y;
    double next = y - f / slope;
    if (!std::isfinite(f) || !(next > low && next < high) || i % 8 == 7) next = 0.5 * (low + high);
    if (!(next > low && next < high)) break;
    const double f_next = log_ratio(next);
    if (std::isfinite(f) && std::isfinite(f_next)) slope = std::clamp((f_next - f) / (next - y), 0.05, 20.0);
    y = next, f = f_next;
  }
  return y > 33.0 ? h : sinkage(y);
}

void WheelOnSoil::fill_loads(ContactState& state, const Vertical& vertical) const {
  const ContactGeometry g = vertical.geometry(state.sinkage, state.deflection);
  state.hub_displacement = state.sinkage + state.deflection;
  state.entry_angle = g.theta_1;
  state.exit_angle = vertical.at_rest ? -g.theta_1 : g.theta_2;
  state.deflection_angle = g.theta_d;
  state.peak_angle = vertical.at_rest ? 0.0 : g.theta_m;
  if (g.z <= 0.0) return;
  state.grousers_in_soil = wheel_.grousers *
                           (g.front - (vertical.at_rest ? -g.front : -g.rear) + 2.0 * std::sin(g.theta_d)) /
                           (2.0 * M_PI);
  // Loose soil carries at the sinkage z what the law's carries at z / factor: all stresses are that much
  // smaller.
  if (vertical.at_rest) {
    state.normal_load = vertical.force(state.sinkage / vertical.sinkage_factor, state.deflection);
    return;
  }
  const ContactLoads loads = vertical.loads(g);
  double strength = 1.0;
  if (vertical.sinkage_factor != 1.0)
    strength = vertical.force(g.z / vertical.sinkage_factor, g.delta_d) / loads.vertical;
  state.normal_load = strength * loads.vertical;
  state.thrust = strength * loads.thrust;
  state.grouser_thrust = strength * loads.grouser_thrust;
  state.compaction_resistance = strength * loads.compaction_resistance;
  state.bulldozing_force = strength * loads.bulldozing;
  state.flexing_resistance = vertical.motion.rolling > 0.0 ? wheel_.flexing_resistance : 0.0;
  state.drive_torque = strength * loads.torque;
  const double along =
      state.thrust + state.grouser_thrust - state.compaction_resistance - state.flexing_resistance;
  const double across = strength * (loads.side_shear + loads.bulldozing);
  const double moment_x = strength * loads.moment_x;
  const double cos_b = std::cos(vertical.operation.steering_angle),
               sin_b = std::sin(vertical.operation.steering_angle);
  state.drawbar_pull = along * cos_b - across * sin_b;
  state.side_force = along * sin_b + across * cos_b;
  state.torque_x = moment_x * cos_b + state.drive_torque * sin_b;
  state.torque_y = moment_x * sin_b - state.drive_torque * cos_b;
  state.torque_z = strength * loads.moment_z;
}

WheelOnSoil::Vertical WheelOnSoil::rolling(const Operation& operation, const SoilChange& change) const {
  const double peak = peak_position(soil_, operation.slip);
  return {*this, law(change), change.sinkage_factor, false, operation, checked_motion(operation), peak};
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
  const double force = state.normal_load;
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
