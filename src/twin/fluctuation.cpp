#include "twin/fluctuation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "effects/catalogue.h"

namespace wheel_twin::twin {
namespace {

/// Steepest unevenness that is credible: a bed whose stiffness varies by a factor of two.
constexpr double largest_unevenness = 0.7;

LogDeviation with_other_noise(LogDeviation simulated, const FluctuationModel& fluctuation) {
  const bool told =
      std::any_of(simulated.begin(), simulated.end(), [](double d) { return std::isfinite(d); });
  for (std::size_t c = 0; told && c < channel_count; ++c) {
    const double made = std::isfinite(simulated[c]) ? std::exp(simulated[c]) : 0.0;
    simulated[c] = std::log(std::max(1e-12, std::hypot(made, fluctuation.other[c]))) + fluctuation.beyond[c];
  }
  return simulated;
}

/// NaN where the soft places of the bed let the wheel sink to its axle.
LogDeviation on_uneven_bed(const TwinConfig& model, const RunGrid& grid, const Unevenness& unevenness) {
  try {
    return log_deviation(grid, simulate(model, grid, unevenness));
  } catch (const Error&) {
    LogDeviation untold;
    untold.fill(std::numeric_limits<double>::quiet_NaN());
    return untold;
  }
}

/// While moving, of the bins from `begin` up to `end`.
LogDeviation log_deviation_between(const RunGrid& grid, const Predicted& rows, int begin, int end) {
  LogDeviation result;
  for (int c = 0; c < channel_rows; ++c) {
    std::vector<double> fluctuation;
    for (const Segment& segment : segments_of(grid)) {
      if (!segment.moving) continue;
      std::vector<double> values;
      for (int i = std::max(begin, segment.begin); i < std::min(end, segment.end); ++i)
        if (std::isfinite(rows(c, i)) && std::isfinite(grid.measured(c, i))) values.push_back(rows(c, i));
      const std::vector<double> level_free = without_level(values);
      fluctuation.insert(fluctuation.end(), level_free.begin(), level_free.end());
    }
    const double deviation = fluctuation.size() >= 20 ? robust_deviation(fluctuation) : 0.0;
    result[static_cast<std::size_t>(c)] =
        deviation > 0.0 ? std::log(deviation) : std::numeric_limits<double>::quiet_NaN();
  }
  return result;
}

}  // namespace

LogDeviation mean_of(const std::vector<LogDeviation>& several) {
  LogDeviation mean;
  for (std::size_t c = 0; c < channel_count; ++c) {
    double sum = 0.0;
    int count = 0;
    for (const LogDeviation& one : several)
      if (std::isfinite(one[c])) {
        sum += one[c];
        ++count;
      }
    mean[c] = count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
  }
  return mean;
}

LogDeviation log_deviation(const RunGrid& grid, const Predicted& rows) {
  return log_deviation_between(grid, rows, 0, grid.bins());
}

std::vector<LogDeviation> log_deviation_by_stretch(const RunGrid& grid, const Predicted& rows) {
  constexpr int most = 4, fewest_bins = 24;  // of a stretch
  const int stretches = std::clamp(grid.bins() / fewest_bins, 1, most);
  std::vector<LogDeviation> result;
  for (int k = 0; k < stretches; ++k)
    result.push_back(
        log_deviation_between(grid, rows, grid.bins() * k / stretches, grid.bins() * (k + 1) / stretches));
  return result;
}

FluctuationModel fit_fluctuation(const TwinConfig& model, const std::vector<const RunGrid*>& references,
                                 const std::vector<Residual>& residuals) {
  FluctuationModel fluctuation;
  if (references.empty()) return fluctuation;
  std::vector<LogDeviation> measured;
  for (std::size_t r = 0; r < references.size(); ++r)
    measured.push_back(log_deviation(*references[r], residuals[r].bins));
  const LogDeviation target = mean_of(measured);
  const auto hub = static_cast<std::size_t>(index_of(Channel::hub_displacement));
  if (!std::isfinite(target[hub])) return fluctuation;

  const RunGrid& middle = *references[references.size() / 2];
  const NoiseModel noise = estimate_noise({&middle}, {residuals[references.size() / 2]}, NoiseFloor{});
  double travel = 0.0;
  int moving = 0;
  for (int i = 0; i < middle.bins(); ++i)
    if (middle.moving[static_cast<std::size_t>(i)]) {
      const auto& m = middle.motion[static_cast<std::size_t>(i)];
      travel +=
          middle.bin * std::max(std::abs(m.carriage_velocity), model.wheel.radius * std::abs(m.wheel_rate));
      ++moving;
    }
  if (moving == 0) return fluctuation;
  const double keep = std::clamp(noise[hub].keep, 0.05, 0.9);
  fluctuation.unevenness.correlation_length = travel / moving / -std::log(keep);
  fluctuation.unevenness.deviation = 0.05;
  // The hub's fluctuation is nearly proportional to the unevenness: two corrections suffice.
  LogDeviation simulated{};
  for (int iteration = 0; iteration < 3; ++iteration) {
    std::vector<LogDeviation> runs;
    for (const RunGrid* grid : references)
      runs.push_back(on_uneven_bed(model, *grid, fluctuation.unevenness));
    simulated = mean_of(runs);
    if (!std::isfinite(simulated[hub])) return fluctuation;
    if (iteration < 2)
      fluctuation.unevenness.deviation = std::min(
          largest_unevenness, fluctuation.unevenness.deviation * std::exp(target[hub] - simulated[hub]));
  }
  for (std::size_t c = 0; c < channel_count; ++c) {
    const double total = std::isfinite(target[c]) ? std::exp(target[c]) : 0.0;
    const double made = std::isfinite(simulated[c]) ? std::exp(simulated[c]) : 0.0;
    fluctuation.other[c] = total > made ? std::sqrt(total * total - made * made) : 0.1 * total;
  }
  fluctuation.known = true;
  return fluctuation;
}

std::vector<LogDeviation> fluctuation_beyond(const FluctuationModel& fluctuation, const TwinConfig& model,
                                             const std::vector<const RunGrid*>& references,
                                             const std::vector<Residual>& residuals,
                                             const std::vector<const RunGrid*>& runs) {
  std::vector<LogDeviation> result(runs.size());
  if (!fluctuation.known) return result;
  std::vector<LogDeviation> excess;
  for (std::size_t g = 0; g < references.size(); ++g) {
    const LogDeviation measured = log_deviation(*references[g], residuals[g].bins);
    const LogDeviation predicted = predicted_log_deviation(model, *references[g], fluctuation);
    excess.emplace_back();
    for (std::size_t c = 0; c < channel_count; ++c) excess.back()[c] = measured[c] - predicted[c];
  }
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::vector<double> weights = nearness(references, *runs[r]);
    for (std::size_t c = 0; c < channel_count; ++c) {
      double sum = 0.0, known = 0.0;
      for (std::size_t g = 0; g < excess.size(); ++g) {
        if (!std::isfinite(excess[g][c])) continue;
        sum += weights[g] * excess[g][c];
        known += weights[g];
      }
      result[r][c] = known > 0.0 ? sum / known : 0.0;
    }
  }
  return result;
}

std::optional<double> common_tone(const std::vector<const RunGrid*>& grids,
                                  const std::vector<Residual>& residuals) {
  constexpr double most = 0.5;     // of the variance
  constexpr int least_cycles = 4;  // in a run: slower courses are levels and trends
  for (int c = 0; c < channel_rows; ++c) {
    std::vector<double> tones;
    for (std::size_t g = 0; g < grids.size(); ++g) {
      std::vector<double> values;
      for (int i = 0; i < grids[g]->bins(); ++i)
        if (grids[g]->moving[static_cast<std::size_t>(i)] && std::isfinite(residuals[g].bins(c, i)))
          values.push_back(residuals[g].bins(c, i));
      const auto n = static_cast<int>(values.size());
      double mean = 0.0, variance = 0.0, strongest = 0.0, tone = 0.0;
      for (const double v : values) mean += v / n;
      for (const double v : values) variance += (v - mean) * (v - mean) / n;
      // Half steps of the Fourier frequencies: no tone falls between two.
      for (int k = 2 * least_cycles; k < n / 2; ++k) {
        const double turn = M_PI * k / n;  // a bin
        double along = 0.0, across = 0.0;
        for (int i = 0; i < n; ++i) {
          along += (values[static_cast<std::size_t>(i)] - mean) * std::cos(turn * i);
          across += (values[static_cast<std::size_t>(i)] - mean) * std::sin(turn * i);
        }
        const double power = 2.0 * (along * along + across * across) / (static_cast<double>(n) * n);
        if (power > strongest) strongest = power, tone = turn / (2.0 * M_PI * grids[g]->bin);
      }
      if (strongest > most * variance) tones.push_back(tone);
    }
    if (2 * tones.size() <= grids.size()) continue;
    std::sort(tones.begin(), tones.end());
    const double middle = tones[tones.size() / 2];
    const auto alike = std::count_if(tones.begin(), tones.end(),
                                     [&](double tone) { return std::abs(tone / middle - 1.0) < 0.1; });
    if (2 * static_cast<std::size_t>(alike) > grids.size()) return middle;
  }
  return std::nullopt;
}

bool is_friction(const EffectSetting& setting) {
  const auto effect = effects::make_effect(effects::find_effect(setting.name), setting.values);
  rig::Ports ports;
  effect->attach(ports);
  return std::any_of(ports.rig.begin(), ports.rig.end(),
                     [](const rig::RigPort* port) { return port->coulomb_friction({}) > 0.0; });
}

bool sticks(const TwinConfig& model) {
  return std::any_of(model.effects.begin(), model.effects.end(), is_friction);
}

TwinConfig without_friction(TwinConfig model) {
  model.effects.erase(std::remove_if(model.effects.begin(), model.effects.end(), is_friction),
                      model.effects.end());
  return model;
}

Predicted slow_course(const TwinConfig& model, const RunGrid& grid) {
  return simulate(without_friction(model), grid);
}

Fluctuating simulate_fluctuating(const TwinConfig& model, const RunGrid& grid,
                                 const FluctuationModel& fluctuation) {
  constexpr std::uint64_t beds = 2;
  Fluctuating result;
  std::vector<LogDeviation> deviations;
  for (std::uint64_t bed = 1; bed <= beds; ++bed) {
    Unevenness unevenness = fluctuation.unevenness;
    unevenness.seed = bed;
    deviations.push_back(on_uneven_bed(model, grid, unevenness));
  }
  result.log_deviation = with_other_noise(mean_of(deviations), fluctuation);
  result.course = slow_course(model, grid);
  return result;
}

LogDeviation predicted_log_deviation(const TwinConfig& model, const RunGrid& grid,
                                     const FluctuationModel& fluctuation) {
  return with_other_noise(on_uneven_bed(model, grid, fluctuation.unevenness), fluctuation);
}

}  // namespace wheel_twin::twin
