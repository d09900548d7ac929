#include "draw.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "effects/catalogue.h"
#include "rig/semi_empirical_contact.h"
#include "terramechanics/wheel_on_soil.h"

namespace wheel_twin::blind {
namespace {

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

std::size_t pick(Random& random, std::size_t count) {
  return std::min(count - 1, static_cast<std::size_t>(random.uniform() * static_cast<double>(count)));
}

/// Stiffness that varies along the travel of rim or carriage as a first-order process.
class Uneven final : public rig::SoilPort {
 public:
  Uneven(const Drawn& drawn, std::uint64_t seed) {
    Random random(seed, 11);
    const double keep = std::exp(-spacing / drawn.correlation_length);
    double value = random.normal();
    for (int i = 0; i < 4000; ++i) {
      value = keep * value + std::sqrt(1.0 - keep * keep) * random.normal();
      factor_.push_back(std::exp(drawn.unevenness * value));
    }
  }
  double stiffness_factor(const rig::RigState& state) const override {
    const double place = std::max(state.rim_travel, std::abs(state.x)) / spacing;
    const auto i = std::min(factor_.size() - 2, static_cast<std::size_t>(place));
    const double share = std::min(1.0, place - static_cast<double>(i));
    return factor_[i] * (1.0 - share) + factor_[i + 1] * share;
  }

 private:
  static constexpr double spacing = 0.001;  // m
  std::vector<double> factor_;
};

/// What the simulated soil does that the twin's cannot.
class OtherForm final : public rig::SoilPort {
 public:
  explicit OtherForm(const std::vector<ModelForm>& forms) : forms_(forms) {}
  bool layered() const override {
    return std::any_of(forms_.begin(), forms_.end(),
                       [](const ModelForm& f) { return f.name == "hyperbolic"; });
  }
  /// Pressure that levels off with depth, z / (1 + z / z_0), after Gotteland and Benoit (2006).
  double layer_factor(const rig::RigState&, double depth) const override {
    double factor = 1.0;
    for (const ModelForm& f : forms_)
      if (f.name == "hyperbolic") factor /= 1.0 + f.size * depth / 0.01;
    return factor;
  }
  /// Strength with a peak at small slip (Wong and Preston-Thomas 1983): more thrust there, none at large
  /// slip.
  Eigen::Vector3d added_force(const rig::RigState& state, double normal_load) const override {
    double thrust = 0.0;
    for (const ModelForm& f : forms_)
      if (f.name == "peak") {
        const double s = std::abs(state.slip) / 0.15;
        thrust += f.size * normal_load * s * std::exp(1.0 - s) * (state.slip < 0.0 ? -1.0 : 1.0);
      }
    return {thrust, 0.0, 0.0};
  }

 private:
  const std::vector<ModelForm>& forms_;
};

/// Causes that no effect of the catalogue describes.
class Outside final : public rig::SensorPort {
 public:
  Outside(const std::string& name, double size) : name_(name), size_(size) {}
  void change_wrench(const rig::RigState& state, rig::WrenchReading& reading) const override {
    if (name_ == "belt_period") reading.force.x() += size_ * std::sin(2.0 * M_PI * state.x / 0.037);
    if (name_ == "slow_beat") reading.force.z() += size_ * std::sin(2.0 * M_PI * state.time / 7.3);
    if (name_ == "hum") reading.force.y() += size_ * std::sin(2.0 * M_PI * 5.3 * state.time);
    if (name_ == "dropout" && state.time > 20.0 && state.time < 26.0) reading.force *= 1.0 - size_;
    if (name_ == "saturation") reading.force.x() = std::clamp(reading.force.x(), -size_, size_);
  }
  void change_displacement(const rig::RigState& state, double, double& displacement) const override {
    if (name_ == "wire_slip") displacement += size_ * std::floor(state.time / 9.0);
  }

 private:
  std::string name_;
  double size_;
};

twin::EffectSetting draw_effect(Random& random, const Drawn& drawn) {
  std::vector<const effects::EffectType*> types;
  for (const effects::EffectType& type : effects::catalogue())
    if (type.name != "bulldozing" && type.name != "draw_wire_drift") types.push_back(&type);
  // Bulldozing acts on braked wheels, which are not drawn; a drift takes turns with a jump, so that the
  // experiments drawn before the catalogue had it are drawn as they were.
  const effects::EffectType* drawn_type = types[pick(random, types.size())];
  if (drawn_type->name == "draw_wire_jump" &&
      Random(static_cast<std::uint64_t>(1e6 * drawn.soil.phi), 9).uniform() < 0.5)
    drawn_type = &effects::find_effect("draw_wire_drift");
  const effects::EffectType& type = *drawn_type;
  twin::EffectSetting setting{type.name, {}};
  for (const effects::Parameter& p : type.parameters) {
    double value;
    if (p.periodic) {
      value = random.uniform(p.lower, p.upper);
    } else if (p.name == "position") {
      value = random.uniform(0.15, 0.45);
    } else if (p.name == "time") {
      value = random.uniform(15.0, 40.0);
    } else if (std::isnan(p.neutral)) {
      value = p.scale * log_uniform(random, 0.7, 1.5);
    } else if (p.neutral >= p.upper) {
      value = p.scale * log_uniform(random, 0.4, 1.2);
    } else {
      const double sign = p.neutral > p.lower && random.uniform() < 0.5 ? -1.0 : 1.0;
      value = p.neutral + sign * p.scale * log_uniform(random, 0.5, 2.0);
    }
    setting.values.push_back(std::clamp(value, p.lower, p.upper));
  }
  // An added weight must leave some load, a compliance be felt at this load.
  if (type.name == "dead_weight_error") setting.values[0] *= drawn.run.conditions.load / 60.0;
  return setting;
}

void draw_wheel_and_soil(Random& random, Drawn& d) {
  d.wheel.name = "drawn";
  d.wheel.radius = random.uniform(0.06, 0.14);
  d.wheel.width = d.wheel.radius * random.uniform(0.5, 1.1);
  if (random.uniform() < 0.7) {
    d.wheel.grousers = 12.0 + std::floor(random.uniform(0.0, 13.0));
    d.wheel.grouser_height = random.uniform(0.003, 0.012);
  }
  terramechanics::Soil& s = d.soil;
  s.name = "drawn_sand";
  s.k_c = random.uniform(500.0, 3000.0);
  s.n = random.uniform(0.85, 1.25);
  s.k_phi = log_uniform(random, 4e5, 2e6) * std::pow(0.01, 1.0 - s.n);
  s.c = random.uniform() < 0.5 ? 0.0 : random.uniform(0.0, 400.0);
  s.phi = random.uniform(0.5, 0.75);
  s.K = random.uniform(0.01, 0.03);
  s.c1 = random.uniform(0.1, 0.45);
  s.c2 = random.uniform(0.0, 0.25);
  s.gamma = random.uniform(0.0, 0.6);
  d.run.conditions.load = log_uniform(random, 20.0, 90.0) * d.wheel.radius / 0.09;
  if (random.uniform() < 0.6)
    d.wheel.stiffness = d.run.conditions.load / (d.wheel.radius * random.uniform(0.015, 0.05));
  d.declared = s;
  d.declared.k_phi *= std::exp(0.25 * random.normal());
  d.declared.k_c *= std::exp(0.25 * random.normal());
  d.declared.n += 0.05 * random.normal();
  d.declared.phi += 0.05 * random.normal();
  d.declared.K *= std::exp(0.25 * random.normal());
  d.declared.c = 0.5 * s.c;
  d.declared.c1 = std::clamp(s.c1 + 0.05 * random.normal(), 0.05, 0.6);
  d.declared.c2 = std::clamp(s.c2 + 0.05 * random.normal(), 0.0, 0.4);
  d.declared.gamma = 0.3;
}

bool carried(const Drawn& d) {
  try {
    const terramechanics::WheelOnSoil model(d.wheel, d.soil);
    for (const double slip : {0.0, 0.6}) {
      const auto state = model.at_load(1.3 * d.run.conditions.load, {slip, 0.0});
      if (state.hub_displacement > 0.2 * d.wheel.radius || state.hub_displacement < 0.03 * d.wheel.radius)
        return false;
    }
  } catch (const Error&) {
    return false;
  }
  return true;
}

void draw_instruments(Random& random, Drawn& d) {
  rig::RunSettings& run = d.run;
  run.step = 0.004;
  run.radius = d.wheel.radius;
  run.rig.mount.arm_z = random.uniform(0.05, 0.25);
  run.rig.mount.drive_torque_share = random.uniform() < 0.5 ? -1.0 : 1.0;
  run.rig.drive.coulomb_loss = random.uniform(0.0, 0.2);
  const double rate = random.uniform() < 0.5 ? 50.0 : 100.0;
  run.sensors.ft.rate = rate;
  const double noise = random.uniform(0.03, 0.12);
  for (int i = 0; i < 6; ++i) {
    const bool force = i < 3;
    run.sensors.ft.noise[i] = noise * random.uniform(0.6, 1.8) * (force ? 1.0 : 0.02);
    run.sensors.ft.resolution[i] = force ? 1.0 / 16.0 : 1.0 / 752.0;
  }
  run.sensors.draw_wire.rate = rate;
  run.sensors.draw_wire.noise = random.uniform(1e-5, 5e-5);
  run.sensors.joints.rate = rate;
  run.sensors.joints.effort_noise = 0.01;
  run.sensors.temperature.rate = 1.0;
  run.profile.travel = 0.0;
  run.profile.longest_steady = 55.0;
  run.conditions.wheel_speed = random.uniform(0.2, 0.4) * 0.09 / d.wheel.radius;
  d.unevenness = random.uniform(0.02, 0.07);
  d.correlation_length = random.uniform(0.005, 0.02);
}

}  // namespace

run_log::RunLog simulate_run(const Drawn& d, double slip, bool hidden, std::uint64_t seed, bool even) {
  rig::Ports ports;
  std::vector<std::unique_ptr<effects::Effect>> effects;
  if (hidden)
    for (const twin::EffectSetting& setting : d.effects) {
      effects.push_back(effects::make_effect(effects::find_effect(setting.name), setting.values));
      effects.back()->attach(ports);
    }
  const Outside outside(d.outside, d.outside_size);
  if (hidden && !d.outside.empty()) ports.sensor.push_back(&outside);
  const Uneven uneven(d, seed);
  const OtherForm other(d.forms);
  if (!even) ports.soil.push_back(&uneven);
  ports.soil.push_back(&other);
  rig::RunSettings settings = d.run;
  Random random(seed, 5);
  settings.conditions.slip = slip;
  settings.conditions.temperature = 22.0 + random.uniform(-2.0, 4.0);
  settings.conditions.temperature_rate = random.uniform(-0.03, 0.05);
  settings.conditions.wheel_angle = random.uniform(0.0, 2.0 * M_PI);
  settings.seed = seed;
  settings.epoch = 1.7e9 + 100.0 * static_cast<double>(seed % 1000);
  rig::SemiEmpiricalOptions options;
  options.start_up = 0.5;
  options.table = std::make_shared<terramechanics::ContactTable>(d.wheel, d.soil);
  rig::SemiEmpiricalContact contact(d.wheel, d.soil, ports, options);
  rig::FreeRun run(settings, contact, ports);
  rig::RunSummary summary;
  return rig::run_to_end(run, summary);
}

namespace {

/// Means of forces, displacement and effort over thirds of the steady part.
std::vector<double> course(const run_log::RunLog& log) {
  std::vector<double> values;
  const auto mean = [&](const std::vector<double>& time, auto value) {
    for (int part = 0; part < 6; ++part) {
      const double span = time.back() - time.front(), begin = time.front() + span * (0.2 + 0.12 * part);
      double sum = 0.0;
      int count = 0;
      for (std::size_t i = 0; i < time.size(); ++i)
        if (time[i] >= begin && time[i] < begin + 0.12 * span) sum += value(i), ++count;
      values.push_back(count > 0 ? sum / count : 0.0);
    }
  };
  mean(log.ft.time, [&](std::size_t i) { return log.ft.force[i].x(); });
  mean(log.ft.time, [&](std::size_t i) { return log.ft.force[i].y(); });
  mean(log.ft.time, [&](std::size_t i) { return log.ft.force[i].z(); });
  mean(log.draw_wire.time, [&](std::size_t i) { return log.draw_wire.value[i]; });
  mean(log.joints.time, [&](std::size_t i) { return log.joints.wheel_effort[i]; });
  return values;
}

/// Largest change that the hidden cause makes of any mean, over what the granular bed makes of it between
/// runs.
double visibility(const Drawn& d) {
  const std::vector<double> without = course(simulate_run(d, 0.4, false, 77, false)),
                            with = course(simulate_run(d, 0.4, true, 77, false)),
                            again = course(simulate_run(d, 0.4, false, 78, false));
  double worst = 0.0;
  for (std::size_t c = 0; c < 5; ++c) {
    double noise = 0.0, change = 0.0;
    for (std::size_t k = 6 * c; k < 6 * c + 6; ++k) {
      noise += std::pow(without[k] - again[k], 2);
      change += std::pow(with[k] - without[k], 2);
    }
    const double least = c == 3 ? 2e-5 : c == 4 ? 0.003 : 0.03;
    worst = std::max(worst, std::sqrt(change / std::max(noise, 6.0 * least * least)));
  }
  return worst;
}

bool shows_in_means(const std::vector<twin::EffectSetting>& effects) {
  return std::none_of(effects.begin(), effects.end(), [](const twin::EffectSetting& e) {
    return e.name == "slide_friction" || e.name == "clock_skew" || e.name == "wheel_eccentricity" ||
           e.name == "buried_rock" || e.name == "soft_spoke";
  });
}

}  // namespace

Drawn draw(std::uint64_t seed) {
  Random random(seed, 3);
  for (int attempt = 0; attempt < 200; ++attempt) {
    Drawn d;
    draw_wheel_and_soil(random, d);
    if (!carried(d)) continue;
    draw_instruments(random, d);
    const double form = random.uniform();
    if (form < 0.3) d.forms.push_back({"hyperbolic", random.uniform(0.05, 0.3)});
    if (form > 0.2 && form < 0.5) d.forms.push_back({"peak", random.uniform(0.005, 0.03)});
    d.slips = {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
    if (random.uniform() > 0.15) d.reference_slips = {0.0, 0.2, 0.4, 0.6};
    const double kind = random.uniform();
    if (kind < 0.12) return d;
    if (kind < 0.22) {
      const std::vector<std::pair<std::string, double>> causes = {
          {"belt_period", 0.03 * d.run.conditions.load},
          {"slow_beat", 0.03 * d.run.conditions.load},
          {"dropout", 0.2},
          {"saturation", 0.12 * d.run.conditions.load},
          {"wire_slip", 0.001}};
      const auto& cause = causes[pick(random, causes.size())];
      d.outside = cause.first;
      d.outside_size = cause.second * random.uniform(0.7, 1.6);
    } else {
      d.effects.push_back(draw_effect(random, d));
      if (kind < 0.37) {
        d.effects.push_back(draw_effect(random, d));
        if (d.effects[0].name == d.effects[1].name) continue;
      }
    }
    try {
      bool visible = true;
      for (const twin::EffectSetting& one : d.effects) {
        Drawn alone = d;
        alone.effects = {one};
        if (shows_in_means(alone.effects) && visibility(alone) < 2.0) visible = false;
      }
      if (!d.outside.empty()) visible = true;
      if (!visible) continue;
      simulate_run(d, 0.6, true, 5, false);
    } catch (const Error&) {
      continue;
    }
    return d;
  }
  throw Error("blind experiments: nothing could be drawn with seed " + std::to_string(seed));
}

}  // namespace wheel_twin::blind
