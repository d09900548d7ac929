#include "twin/steady_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.h"
#include "rig/replay.h"
#include "rig/semi_empirical_contact.h"
#include "rig/speeds.h"
#include "twin/metrics.h"

namespace wheel_twin::twin {
namespace {

constexpr int bins = 2;  // the start and the centre of the window

bool forces_over_time(const RunGrid& grid) {
  return grid.has(Channel::drawbar_pull) || grid.has(Channel::normal_load) || grid.has(Channel::side_force);
}

const logs::Average* average_of(const logs::Run& run, Channel channel) {
  if (!run.averages) return nullptr;
  const auto& a = window_average(*run.averages, channel);
  return a ? &*a : nullptr;
}

bool same_condition(const logs::Run& a, const logs::Run& b) {
  constexpr double one_degree = 0.0174533;
  return std::abs(a.slip - b.slip) < 0.02 && std::abs(a.steering_angle - b.steering_angle) < one_degree &&
         std::abs(a.load - b.load) <= 0.02 * std::max(a.load, b.load);
}

/// Standard deviation of a window mean as the window itself tells: its scatter over few independent values.
double window_error(const logs::Average& average) {
  constexpr double independent = 3.0;
  return average.std ? *average.std / std::sqrt(independent) : 0.0;
}

}  // namespace

double SteadyScatter::total() const {
  return std::hypot(within, between);
}

double leading_load(const logs::Run& run) {
  return run.averages && run.averages->normal_load ? run.averages->normal_load->mean : run.load;
}

double leading_steering(const logs::Run& run) {
  constexpr double unsteered = 2e-3;  // rad; what an encoder's zero is worth
  return std::abs(run.steering_angle) < unsteered ? 0.0 : run.steering_angle;
}

bool known_by_means(const std::vector<RunGrid>& grids) {
  bool any = false;
  for (const RunGrid& grid : grids) {
    if (grid.declared.role != logs::Role::measured) continue;
    if (!grid.declared.averages || forces_over_time(grid)) return false;
    any = true;
  }
  return any;
}

double SteadyScatter::independent() const {
  return std::hypot(within, tolerance);
}

SteadyRun steady_run(const logs::Run& run, const std::string& name, double radius) {
  if (!run.averages) throw Error(fmt::format("{}: no window averages", name));
  SteadyRun steady;
  RunGrid& grid = steady.grid;
  grid.name = name;
  grid.declared = run;
  grid.declared.load = leading_load(run);
  grid.declared.steering_angle = leading_steering(run);
  if (!(grid.declared.load > 0.0))
    throw Error(fmt::format("{}: a normal load of {:.3g} N carries no wheel: sign or tare", name,
                            grid.declared.load));
  const double centre = 0.5 * (run.averages->window_start + run.averages->window_end);
  grid.bin = centre;
  const rig::Speeds speeds = rig::speeds_of_slip(run.slip, run.wheel_speed, radius);
  if (speeds.carriage == 0.0 && speeds.wheel == 0.0)
    throw Error(fmt::format("{}: neither wheel nor carriage moves", name));
  for (int i = 0; i < bins; ++i) {
    rig::MeasuredMotion m;
    m.time = i * centre;
    m.carriage_velocity = speeds.carriage;
    m.wheel_rate = speeds.wheel;
    m.carriage_position = speeds.carriage * m.time;
    m.wheel_angle = speeds.wheel * m.time;
    m.load = grid.declared.load;
    m.steering_angle = grid.declared.steering_angle;
    grid.motion.push_back(m);
  }
  grid.measured.setConstant(channel_rows, bins, std::numeric_limits<double>::quiet_NaN());
  grid.slip.setConstant(bins, run.slip);
  grid.moving.assign(bins, true);
  for (const Channel channel : all_channels)
    if (const logs::Average* average = average_of(run, channel))
      grid.windows.push_back({channel, centre - 0.1 * grid.bin, centre + 0.1 * grid.bin, average->mean});
  if (grid.windows.empty()) throw Error(fmt::format("{}: averages without a channel", name));
  steady.reference = run.role == logs::Role::reference;
  return steady;
}

SteadyNoise steady_noise(const logs::Experiment& experiment, const std::vector<SteadyRun>& runs) {
  double load = 1.0, displacement = 1e-3;
  for (const SteadyRun& run : runs) {
    load = std::max(load, run.grid.declared.load);
    if (const auto* z = average_of(run.grid.declared, Channel::hub_displacement))
      displacement = std::max(displacement, std::abs(z->mean));
  }
  const double torque = 0.02 * load * experiment.wheel.radius;
  const std::array<double, channel_count> assumed = {
      0.02 * load, 0.02 * load, 0.02 * load, std::max(2e-4, 0.02 * displacement), torque, torque};
  SteadyNoise noise;
  for (const Channel channel : all_channels) {
    const auto c = index_of(channel);
    // Half of the squared difference of two runs of one condition has the variance as its mean.
    double same = 0.0, other = 0.0, window = 0.0;
    int same_pairs = 0, other_pairs = 0, windows = 0;
    for (std::size_t i = 0; i < experiment.runs.size(); ++i) {
      const logs::Run& a = experiment.runs[i];
      const auto* x = average_of(a, channel);
      if (x == nullptr || !is_straight(a)) continue;
      window += std::pow(window_error(*x), 2);
      ++windows;
      for (std::size_t j = i + 1; j < experiment.runs.size(); ++j) {
        const logs::Run& b = experiment.runs[j];
        const auto* y = average_of(b, channel);
        if (y == nullptr || !same_condition(a, b)) continue;
        const bool together = !a.group.empty() && a.group == b.group;
        (together ? same : other) += 0.5 * std::pow(x->mean - y->mean, 2);
        ++(together ? same_pairs : other_pairs);
      }
    }
    SteadyScatter& s = noise[c];
    s.pairs = same_pairs + other_pairs;
    constexpr int enough = 3;  // pairs for a variance of their own
    double total = assumed[c] * assumed[c];
    if (s.pairs >= enough)
      total = (same + other) / s.pairs;
    else if (windows > 0)
      total = std::max(total, window / windows);
    const double least = 0.25 * assumed[c];
    total = std::max(total, least * least);
    // Half of the variance is taken to be that of groups where repeats do not tell.
    double between = 0.5 * total;
    if (same_pairs >= enough && other_pairs >= enough)
      between = std::clamp(other / other_pairs - same / same_pairs, 0.1 * total, 0.9 * total);
    s.between = std::sqrt(between);
    s.within = std::sqrt(total - between);
    s.tolerance = assumed[c];
  }
  return noise;
}

std::vector<double> predict_means(const TwinConfig& model, const SteadyRun& run, double* displacement) {
  const RunGrid& grid = run.grid;
  const Acting acting = acting_effects(model);
  rig::SemiEmpiricalContact contact(model.wheel, model.soil, acting.ports);
  rig::RunConditions conditions;
  conditions.slip = grid.declared.slip;
  conditions.load = grid.declared.load;
  conditions.wheel_speed = grid.declared.wheel_speed;
  conditions.steering_angle = grid.declared.steering_angle;
  // The state at the window does not depend on where the slide began: it begins near where it was read.
  rig::ReplayOptions options;
  options.step = grid.motion.back().time;
  options.initial_displacement = 0.3 * model.wheel.radius;
  for (const WindowMean& window : grid.windows)
    if (window.channel == Channel::hub_displacement && window.mean > 0.0)
      options.initial_displacement = window.mean;
  if (displacement != nullptr && *displacement > 0.0) options.initial_displacement = *displacement;
  rig::Replay replay(model.rig, conditions, model.wheel.radius, contact, acting.ports, options);
  replay.update(grid.motion.front());
  const rig::RigStep& step = replay.update(grid.motion.back());
  const rig::Readings& r = step.readings;
  if (displacement != nullptr) *displacement = step.state.hub_displacement;
  const std::array<double, channel_count> values = {r.wrench.force.x(),  r.wrench.force.y(),
                                                    r.wrench.force.z(),  r.displacement,
                                                    r.wrench.torque.y(), r.joints.wheel_effort};
  std::vector<double> means;
  for (const WindowMean& window : grid.windows) {
    double value = values[index_of(window.channel)];
    for (const Correction& correction : model.corrections)
      if (correction.channel == window.channel)
        value += correction.at(grid.declared.slip, grid.declared.load);
    means.push_back(value);
  }
  return means;
}

Means residuals_of(const TwinConfig& model, const TwinConfig& reference_model,
                   const std::vector<const SteadyRun*>& runs) {
  Means residuals;
  for (const SteadyRun* run : runs) {
    residuals.push_back(predict_means(run->reference ? reference_model : model, *run));
    for (std::size_t w = 0; w < residuals.back().size(); ++w)
      residuals.back()[w] = run->grid.windows[w].mean - residuals.back()[w];
  }
  return residuals;
}

bool residuals_for_fit(const TwinConfig& model, const TwinConfig& reference_model,
                       const std::vector<const SteadyRun*>& runs, std::vector<double>& displacements,
                       Means& residuals) {
  std::size_t carried = 0;
  displacements.resize(runs.size(), 0.0);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::vector<WindowMean>& windows = runs[r]->grid.windows;
    std::vector<double> means;
    try {
      means = predict_means(runs[r]->reference ? reference_model : model, *runs[r], &displacements[r]);
      ++carried;
    } catch (const Error&) {
      displacements[r] = 0.0;
      for (const WindowMean& window : windows)
        means.push_back(window.channel == Channel::hub_displacement ? model.wheel.radius
                        : window.channel == Channel::normal_load    ? runs[r]->grid.declared.load
                                                                    : 0.0);
    }
    residuals.emplace_back();
    for (std::size_t w = 0; w < means.size(); ++w) residuals.back().push_back(windows[w].mean - means[w]);
  }
  return carried > 0;
}

void whiten_means(const std::vector<const SteadyRun*>& runs, const Means& residuals, const SteadyNoise& noise,
                  std::vector<double>& out, std::vector<std::size_t>* run_of) {
  for (const Channel channel : all_channels) {
    const SteadyScatter& scatter = noise[index_of(channel)];
    struct Sum {
      double value = 0.0, count = 0.0;
    };
    std::map<std::string, Sum> groups;
    const auto for_each = [&](const auto& act) {
      for (std::size_t r = 0; r < runs.size(); ++r)
        for (std::size_t w = 0; w < residuals[r].size(); ++w)
          if (runs[r]->grid.windows[w].channel == channel) act(r, residuals[r][w]);
    };
    const auto group_of = [&](std::size_t r) {
      return runs[r]->group().empty() ? runs[r]->grid.name : runs[r]->group();
    };
    for_each([&](std::size_t r, double value) {
      Sum& sum = groups[group_of(r)];
      sum.value += value;
      sum.count += 1.0;
    });
    const double ratio = std::pow(scatter.between / scatter.independent(), 2);
    for_each([&](std::size_t r, double value) {
      const Sum& sum = groups[group_of(r)];
      const double shared = (1.0 - 1.0 / std::sqrt(1.0 + sum.count * ratio)) * sum.value / sum.count;
      out.push_back((value - shared) / scatter.independent());
      if (run_of != nullptr) run_of->push_back(r);
    });
  }
}

}  // namespace wheel_twin::twin
