#include "twin/clock_lag.h"

#include <algorithm>
#include <cmath>

#include "logs/statistics.h"
#include "twin/noise.h"

namespace wheel_twin::twin {
namespace {

constexpr std::size_t fewest_references = 3;
constexpr double longest = 2.0;       // s, of the lag that all runs share
constexpr double least_error = 0.01;  // s, of the zero: what soil and load make of the wheel's own lag
constexpr double restless = 4.0;      // scatter of stretches over that of the reference runs
constexpr double nearby = 0.25;       // s, about no lag: where that of a stretch is looked for at least

using Curves = std::array<Eigen::VectorXd, 2>;

Curves sum_of(const LagCurves& curves) {
  Curves sum = curves.stretches.front();
  for (std::size_t k = 1; k < curves.stretches.size(); ++k)
    for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += curves.stretches[k][c];
  return sum;
}

/// What a run like `run` shows when nothing is late.
Curves template_for(const RunGrid& run, const std::vector<const RunGrid*>& references) {
  const std::vector<double> weights = nearness(references, run);
  Curves sum;
  for (std::size_t g = 0; g < references.size(); ++g) {
    const Curves one = sum_of(*references[g]->lag_curves);
    for (std::size_t c = 0; c < sum.size(); ++c) {
      if (g == 0) sum[c] = Eigen::VectorXd::Zero(one[c].size());
      sum[c] += weights[g] * one[c];
    }
  }
  return sum;
}

/// How alike `seen` is to `expected` when that is later by `shift` steps.
double likeness(const Curves& expected, const Curves& seen, int shift) {
  double sum = 0.0;
  for (std::size_t c = 0; c < expected.size(); ++c) {
    const Eigen::Index count = expected[c].size() - std::abs(shift);
    sum += expected[c].segment(std::max(0, -shift), count).dot(seen[c].segment(std::max(0, shift), count));
  }
  return sum;
}

/// The shift at which `likeness_at` is largest, from `low` to `high` steps, in s.
template <typename Function>
double best_shift(int low, int high, const Function& likeness_at) {
  int best = low;
  double most = likeness_at(low);
  for (int shift = low + 1; shift <= high; ++shift) {
    const double value = likeness_at(shift);
    if (value > most) most = value, best = shift;
  }
  double part = 0.0;
  if (best > low && best < high) {
    const double before = likeness_at(best - 1), after = likeness_at(best + 1);
    const double curvature = before - 2.0 * most + after;
    if (curvature < 0.0) part = std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
  }
  return (best + part) * LagCurves::step;
}

int steps(double seconds) {
  return static_cast<int>(std::lround(seconds / LagCurves::step));
}

std::vector<const RunGrid*> with_curves(const std::vector<const RunGrid*>& runs) {
  std::vector<const RunGrid*> result;
  for (const RunGrid* run : runs)
    if (run->lag_curves) result.push_back(run);
  return result;
}

/// The lag on which `measured` agree most, against `references`.
double common_lag(const std::vector<const RunGrid*>& measured,
                  const std::vector<const RunGrid*>& references) {
  std::vector<Curves> expected, seen;
  for (const RunGrid* run : measured) {
    expected.push_back(template_for(*run, references));
    seen.push_back(sum_of(*run->lag_curves));
  }
  return best_shift(-steps(longest), steps(longest), [&](int shift) {
    double sum = 0.0;
    for (std::size_t r = 0; r < seen.size(); ++r) sum += likeness(expected[r], seen[r], shift);
    return sum;
  });
}

/// Lag of each stretch of a run, looked for up to `reach` steps to either side of none.
std::vector<double> stretch_lags(const RunGrid& run, const Curves& expected, int reach) {
  std::vector<double> lags;
  for (const Curves& stretch : run.lag_curves->stretches)
    lags.push_back(best_shift(-reach, reach, [&](int shift) { return likeness(expected, stretch, shift); }));
  return lags;
}

void add_differences(const std::vector<double>& lags, std::vector<double>& differences) {
  const double level = logs::median(lags);
  for (const double lag : lags) differences.push_back(lag - level);
}

/// What reference runs tell of one another.
struct Zero {
  double error = least_error;  // of the common lag, s
  double scatter = 0.0;        // of the stretches of a run, s
};

Zero zero_of(const std::vector<const RunGrid*>& references) {
  std::vector<double> off, within;
  for (const RunGrid* run : references) {
    std::vector<const RunGrid*> others;
    for (const RunGrid* other : references)
      if (other != run) others.push_back(other);
    const std::vector<double> lags = stretch_lags(*run, template_for(*run, others), steps(nearby));
    off.push_back(std::abs(logs::median(lags)));
    add_differences(lags, within);
  }
  // A measured run lies about half as far from the reference runs as they do from one another.
  return {std::max(least_error, 0.5 * logs::median(off) / std::sqrt(static_cast<double>(off.size()))),
          robust_deviation(within)};
}

}  // namespace

double ClockLag::mean() const {
  constexpr double no_chance = 3.0;  // standard errors
  double sum = 0.0, count = 0.0;
  for (const std::vector<double>& lags : by_run)
    for (const double one : lags) sum += one, count += 1.0;
  return count > 0.0 && std::abs(sum) / std::sqrt(count) > no_chance * error ? sum / count : 0.0;
}

void mask_about_changes(double seconds, RunGrid& run) {
  const int bins = run.bins(), reach = static_cast<int>(std::ceil(std::abs(seconds) / run.bin));
  const auto hub = static_cast<Eigen::Index>(index_of(Channel::hub_displacement));
  // What lies beside a change of speed is neither at rest nor moving, and no channel has it.
  std::vector<int> changes;
  for (int i = 0; i < bins; ++i)
    if (run.measured.col(i).array().isNaN().all()) changes.push_back(i);
  for (const int change : changes)
    for (int k = 1; k <= reach; ++k) {
      const int beside = seconds > 0.0 ? change + k : change - k;
      if (beside >= 0 && beside < bins) run.measured(hub, beside) = std::nan("");
    }
}

ClockLag clock_lag(const std::vector<const RunGrid*>& measured,
                   const std::vector<const RunGrid*>& references) {
  ClockLag lag;
  lag.by_run.resize(measured.size());
  const std::vector<const RunGrid*> zero = with_curves(references);
  if (zero.size() < fewest_references || with_curves(measured).empty()) return lag;
  const double common = common_lag(with_curves(measured), zero);
  // Symmetric about no lag: what is found by chance is as often early as late.
  const int reach = steps(std::min(longest, std::max(nearby, 2.0 * std::abs(common))));
  std::vector<double> off, within;
  for (std::size_t r = 0; r < measured.size(); ++r) {
    if (!measured[r]->lag_curves) continue;
    lag.by_run[r] = stretch_lags(*measured[r], template_for(*measured[r], zero), reach);
    for (const double one : lag.by_run[r]) off.push_back(one - common);
    add_differences(lag.by_run[r], within);
  }
  const Zero told = zero_of(zero);
  // A clock is as late here as there; a wheel that sticks is not.
  if (robust_deviation(within) > restless * std::max(0.2 * LagCurves::step, told.scatter)) {
    for (auto& lags : lag.by_run) lags.clear();
    return lag;
  }
  lag.error = std::hypot(std::max(0.2 * LagCurves::step, robust_deviation(off)),
                         std::sqrt(static_cast<double>(off.size())) * told.error);
  return lag;
}

}  // namespace wheel_twin::twin
