#include "twin/common_course.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"

namespace wheel_twin::twin {
namespace {

constexpr double leaving = 4.0;  // s, in which a wheel leaves its print
constexpr std::size_t least_runs = 3;
constexpr int draws = 2000;

/// One run's stretch of values, level removed, from the bin `first` on; NaN where nothing was measured.
struct Stretch {
  int first = 0;
  std::vector<double> values;
};

Stretch stretch_of(const RunGrid& run, const Residual& residual, Eigen::Index channel) {
  Stretch stretch;
  int moving = 0;
  const int skipped = static_cast<int>(std::ceil(leaving / run.bin));
  double sum = 0.0, count = 0.0;
  for (int i = 0; i < run.bins(); ++i) {
    if (!run.moving[static_cast<std::size_t>(i)]) {
      if (!stretch.values.empty()) stretch.values.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    if (++moving <= skipped) continue;
    if (stretch.values.empty()) stretch.first = i;
    const double value = residual.bins(channel, i);
    stretch.values.push_back(value);
    if (std::isfinite(value)) sum += value, count += 1.0;
  }
  while (!stretch.values.empty() && !std::isfinite(stretch.values.back())) stretch.values.pop_back();
  for (double& value : stretch.values) value -= sum / std::max(1.0, count);
  return stretch;
}

/// Mean of the runs at each bin, where enough of them have one.
struct Mean {
  std::vector<double> value;  // NaN where not
  double square = 0.0;        // mean over bins
  double own = 0.0;           // variance of the runs about it
  double runs = 0.0;          // at a bin, in the mean
};

Mean mean_of(const std::vector<Stretch>& stretches, const std::vector<int>& shifts) {
  int end = 0;
  for (const Stretch& s : stretches) end = std::max(end, s.first + static_cast<int>(s.values.size()));
  std::vector<double> sum(static_cast<std::size_t>(end), 0.0), square = sum, count = sum;
  for (std::size_t r = 0; r < stretches.size(); ++r) {
    const auto n = static_cast<int>(stretches[r].values.size());
    for (int i = 0; i < n; ++i) {
      const double value = stretches[r].values[static_cast<std::size_t>((i + shifts[r]) % n)];
      if (!std::isfinite(value)) continue;
      const auto k = static_cast<std::size_t>(stretches[r].first + i);
      sum[k] += value;
      square[k] += value * value;
      count[k] += 1.0;
    }
  }
  Mean mean;
  mean.value.assign(sum.size(), std::numeric_limits<double>::quiet_NaN());
  double bins = 0.0, free = 0.0;
  for (std::size_t k = 0; k < sum.size(); ++k) {
    if (count[k] < std::max<double>(least_runs, 0.6 * static_cast<double>(stretches.size()))) continue;
    mean.value[k] = sum[k] / count[k];
    mean.square += mean.value[k] * mean.value[k];
    mean.own += square[k] - sum[k] * mean.value[k];
    mean.runs += count[k];
    free += count[k] - 1.0;
    bins += 1.0;
  }
  if (bins == 0.0) return mean;
  mean.square /= bins;
  mean.own /= free;
  mean.runs /= bins;
  return mean;
}

}  // namespace

std::optional<CommonCourse> common_course(const std::vector<const RunGrid*>& runs,
                                          const std::vector<Residual>& residuals) {
  std::optional<CommonCourse> best;
  for (const Channel channel : all_channels) {
    std::vector<Stretch> stretches;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      stretches.push_back(stretch_of(*runs[r], residuals[r], index_of(channel)));
      if (stretches.back().values.empty()) stretches.pop_back();
    }
    if (stretches.size() < least_runs) continue;
    const Mean mean = mean_of(stretches, std::vector<int>(stretches.size(), 0));
    if (!(mean.own > 0.0)) continue;
    const double common = std::max(0.0, mean.square - mean.own / mean.runs);
    Random random(1, 23);
    int reached = 0;
    std::vector<int> shifts(stretches.size());
    for (int draw = 0; draw < draws; ++draw) {
      for (std::size_t r = 0; r < shifts.size(); ++r)
        shifts[r] = static_cast<int>(random.uniform() * static_cast<double>(stretches[r].values.size()));
      if (mean_of(stretches, shifts).square >= mean.square) ++reached;
    }
    CommonCourse course;
    course.channel = channel;
    course.deviation = std::sqrt(common);
    course.share = std::sqrt(common / mean.own);
    course.p = std::min(1.0, static_cast<double>(channel_count) * (1.0 + reached) / (1.0 + draws));
    const auto apart = static_cast<std::size_t>(std::max(1.0, std::round(2.0 / runs.front()->bin)));
    for (std::size_t k = 0; k + apart < mean.value.size(); ++k) {
      const double change = mean.value[k + apart] - mean.value[k];
      if (!(std::abs(change) > std::abs(course.change))) continue;
      course.change = change;
      course.time = (static_cast<double>(k) + 0.5 * (1.0 + static_cast<double>(apart))) * runs.front()->bin;
    }
    if (!best || course.share > best->share) best = course;
  }
  return best;
}

}  // namespace wheel_twin::twin
