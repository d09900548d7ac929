#include "twin/metrics.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::twin {
namespace {

constexpr double one_degree = 0.0174533;

bool repeats(const logs::Run& a, const logs::Run& b) {
  const auto in_order = [](const logs::Run& run) { return run.role == logs::Role::reference; };
  return in_order(a) == in_order(b) && std::abs(a.slip - b.slip) < 0.02 &&
         std::abs(a.steering_angle - b.steering_angle) < one_degree &&
         std::abs(a.load - b.load) <= 0.02 * std::max(a.load, b.load);
}

}  // namespace

bool is_straight(const logs::Run& run) {
  return std::abs(run.steering_angle) < one_degree;
}
bool is_driving(const logs::Run& run) {
  return run.slip > 0.05;
}

std::optional<ErrorSummary> error_of(const std::vector<RunComparison>& runs, Channel channel,
                                     const RunFilter& filter) {
  ErrorSummary summary;
  double squares = 0.0;
  for (const RunComparison& run : runs) {
    const auto& compared = run.at(channel);
    if (!compared || !filter(run.run)) continue;
    squares += compared->error * compared->error;
    summary.mean += compared->mean.twin - compared->mean.measured;
    ++summary.runs;
  }
  if (summary.runs == 0) return std::nullopt;
  summary.rmse = std::sqrt(squares / static_cast<double>(summary.runs));
  summary.mean /= static_cast<double>(summary.runs);
  return summary;
}

std::optional<double> error_of_constant(const std::vector<RunComparison>& runs, Channel channel,
                                        const RunFilter& filter) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const RunComparison& run : runs) {
    const auto& compared = run.at(channel);
    if (!compared || !filter(run.run)) continue;
    n += 1.0;
    sum += compared->mean.measured;
    squares += compared->mean.measured * compared->mean.measured;
  }
  if (n < 2.0) return std::nullopt;
  return std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)));
}

std::optional<RepeatScatter> repeat_scatter(const std::vector<RunComparison>& runs, Channel channel,
                                            const RunFilter& filter) {
  std::vector<const RunComparison*> left;
  for (const RunComparison& run : runs)
    if (run.at(channel) && filter(run.run)) left.push_back(&run);
  RepeatScatter scatter;
  double squares = 0.0, freedom = 0.0;
  while (!left.empty()) {
    std::vector<double> same;
    const RunComparison* first = left.front();
    const auto rest = std::partition(
        left.begin(), left.end(), [&](const RunComparison* run) { return !repeats(first->run, run->run); });
    for (auto run = rest; run != left.end(); ++run) same.push_back((*run)->at(channel)->mean.measured);
    left.erase(rest, left.end());
    if (same.size() < 2) continue;
    double mean = 0.0;
    for (const double value : same) mean += value / static_cast<double>(same.size());
    for (const double value : same) squares += (value - mean) * (value - mean);
    freedom += static_cast<double>(same.size() - 1);
    scatter.runs += same.size();
    ++scatter.conditions;
  }
  if (freedom == 0.0) return std::nullopt;
  scatter.std = std::sqrt(squares / freedom);
  return scatter;
}

}  // namespace wheel_twin::twin
