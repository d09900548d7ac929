#include "twin/simulate.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.h"
#include "base/random.h"
#include "effects/catalogue.h"
#include "rig/replay.h"
#include "rig/semi_empirical_contact.h"

namespace wheel_twin::twin {
namespace {

/// One realisation of the unevenness, drawn along the bins of one run.
class UnevenSoil final : public rig::SoilPort {
 public:
  UnevenSoil(const Unevenness& settings, const RunGrid& grid, double radius) : bin_(grid.bin) {
    Random random(settings.seed, 7);
    double value = random.normal();
    for (int i = 0; i < grid.bins(); ++i) {
      const auto& m = grid.motion[static_cast<std::size_t>(i)];
      const double travel =
          grid.bin * std::max(std::abs(m.carriage_velocity), radius * std::abs(m.wheel_rate));
      const double keep = std::exp(-travel / settings.correlation_length);
      value = keep * value + std::sqrt(1.0 - keep * keep) * random.normal();
      factor_.push_back(std::exp(settings.deviation * value));
    }
  }

  double stiffness_factor(const rig::RigState& state) const override {
    const double position = std::clamp(state.time / bin_ - 0.5, 0.0, static_cast<double>(factor_.size() - 1));
    const auto i = static_cast<std::size_t>(position);
    if (i + 1 >= factor_.size()) return factor_.back();
    const double share = position - static_cast<double>(i);
    return factor_[i] * (1.0 - share) + factor_[i + 1] * share;
  }

 private:
  double bin_;
  std::vector<double> factor_;
};

/// The motion at a share of the way from one bin to the next.
rig::MeasuredMotion between(const rig::MeasuredMotion& a, const rig::MeasuredMotion& b, double share) {
  rig::MeasuredMotion m = b;
  for (double rig::MeasuredMotion::*member :
       {&rig::MeasuredMotion::time, &rig::MeasuredMotion::carriage_position,
        &rig::MeasuredMotion::carriage_velocity, &rig::MeasuredMotion::wheel_angle,
        &rig::MeasuredMotion::wheel_rate})
    m.*member = a.*member + share * (b.*member - a.*member);
  return m;
}

/// Measured hub displacement before the run starts to move: where friction left the slide cannot be
/// predicted.
std::optional<double> resting_displacement(const RunGrid& grid) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < grid.bins() && !grid.moving[static_cast<std::size_t>(i)]; ++i) {
    const double d = grid.measured(static_cast<Eigen::Index>(index_of(Channel::hub_displacement)), i);
    if (!std::isfinite(d) || d <= 0.0) continue;
    sum += d;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

}  // namespace

Acting acting_effects(const TwinConfig& model) {
  Acting acting;
  for (const EffectSetting& setting : model.effects)
    acting.add(effects::make_effect(effects::find_effect(setting.name), setting.values));
  return acting;
}

namespace {

/// The motion with the slip of the nearest moving bin where speeds change. There slip is the ratio of two
/// vanishing speeds, which can dig a wheel in to its axle that no one measured.
rig::MotionSeries with_lasting_slip(const RunGrid& grid, double radius) {
  rig::MotionSeries motion = grid.motion;
  const int n = grid.bins();
  std::vector<int> nearest(static_cast<std::size_t>(n), -1);
  const auto sweep = [&](int begin, int end, int step) {
    int last = -1;
    for (int i = begin; i != end; i += step) {
      const auto k = static_cast<std::size_t>(i);
      if (grid.moving[k]) last = i;
      if (last >= 0 && (nearest[k] < 0 || std::abs(i - last) < std::abs(i - nearest[k]))) nearest[k] = last;
    }
  };
  sweep(0, n, 1);
  sweep(n - 1, -1, -1);
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (grid.moving[k] || nearest[k] < 0) continue;
    const rig::MeasuredMotion& like = grid.motion[static_cast<std::size_t>(nearest[k])];
    const double fastest = std::max(std::abs(like.carriage_velocity), std::abs(radius * like.wheel_rate));
    rig::MeasuredMotion& m = motion[k];
    const double share = std::max(std::abs(m.carriage_velocity), std::abs(radius * m.wheel_rate)) / fastest;
    m.carriage_velocity = share * like.carriage_velocity;
    m.wheel_rate = share * like.wheel_rate;
  }
  return motion;
}

Predicted simulate_along(const rig::MotionSeries& motion, const TwinConfig& model, const RunGrid& grid,
                         const std::optional<Unevenness>& unevenness) {
  Acting acting = acting_effects(model);
  rig::Ports& ports = acting.ports;
  std::optional<UnevenSoil> uneven;
  if (unevenness) {
    uneven.emplace(*unevenness, grid, model.wheel.radius);
    ports.soil.push_back(&*uneven);
  }
  rig::RunConditions conditions;
  conditions.slip = grid.declared.slip;
  conditions.load = grid.declared.load;
  conditions.wheel_speed = grid.declared.wheel_speed;
  conditions.steering_angle = grid.declared.steering_angle;
  rig::ReplayOptions options;
  options.step = grid.bin;
  if (unevenness) options.initial_displacement = resting_displacement(grid);
  rig::SemiEmpiricalOptions contact_options;
  contact_options.start_up = model.start_up;
  contact_options.table = model.table;
  rig::SemiEmpiricalContact contact(model.wheel, model.soil, ports, contact_options);
  rig::Replay replay(model.rig, conditions, model.wheel.radius, contact, ports, options);

  const int n = grid.bins();
  Predicted predicted(channel_rows, n);
  constexpr int parts = 5;       // of a bin while a wheel that starts leaves its print
  constexpr int start_bins = 8;  // after the start
  int since_rest = start_bins;
  for (int i = 0; i < n; ++i) {
    since_rest = grid.moving[static_cast<std::size_t>(i)] ? since_rest + 1 : 0;
    for (int k = 1; i > 0 && since_rest < start_bins && k < parts; ++k)
      replay.update(between(motion[static_cast<std::size_t>(i - 1)], motion[static_cast<std::size_t>(i)],
                            static_cast<double>(k) / parts));
    const rig::Readings& r = replay.update(motion[static_cast<std::size_t>(i)]).readings;
    predicted.col(i) << r.wrench.force.x(), r.wrench.force.y(), r.wrench.force.z(), r.displacement,
        r.wrench.torque.y(), r.joints.wheel_effort;
  }
  const double delay = replay.draw_wire_delay();
  if (delay != 0.0) {
    const Eigen::RowVectorXd original = predicted.row(index_of(Channel::hub_displacement));
    for (int i = 0; i < n; ++i) {
      const double position = std::clamp(i - delay / grid.bin, 0.0, n - 1.0);
      const int before = std::min(static_cast<int>(position), n - 2);
      const double share = position - before;
      predicted(index_of(Channel::hub_displacement), i) =
          original[before] * (1.0 - share) + original[before + 1] * share;
    }
  }
  for (const Correction& correction : model.corrections) {
    auto row = predicted.row(index_of(correction.channel));
    for (int i = 0; i < n; ++i)
      if (grid.moving[static_cast<std::size_t>(i)]) row[i] += correction.at(grid.slip[i], grid.declared.load);
  }
  return predicted;
}

}  // namespace

Predicted simulate(const TwinConfig& model, const RunGrid& grid,
                   const std::optional<Unevenness>& unevenness) {
  try {
    return simulate_along(grid.motion, model, grid, unevenness);
  } catch (const Error&) {
    return simulate_along(with_lasting_slip(grid, model.wheel.radius), model, grid, unevenness);
  }
}

Residual residual_of(const RunGrid& grid, const Predicted& predicted) {
  Residual residual;
  residual.bins = grid.measured - predicted;
  for (const WindowMean& window : grid.windows)
    residual.windows.push_back(window.mean - window_mean(predicted, grid, window));
  return residual;
}

double window_mean(const Predicted& predicted, const RunGrid& grid, const WindowMean& window) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < grid.bins(); ++i)
    if (grid.time(i) >= window.start && grid.time(i) <= window.end) {
      sum += predicted(index_of(window.channel), i);
      ++count;
    }
  return count > 0 ? sum / count : std::nan("");
}

}  // namespace wheel_twin::twin
