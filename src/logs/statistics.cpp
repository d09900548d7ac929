#include "logs/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace wheel_twin::logs {

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = std::lround(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

double median(std::vector<double> values) {
  return quantile(std::move(values), 0.5);
}

std::vector<EqualRun> equal_runs(const std::vector<double>& values) {
  std::vector<EqualRun> runs;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (runs.empty() || values[i] != values[i - 1])
      runs.push_back({i, 1});
    else
      ++runs.back().length;
  }
  return runs;
}

double run_length_quantile(const std::vector<EqualRun>& runs, double fraction) {
  std::vector<std::size_t> lengths;
  std::size_t samples = 0;
  for (const EqualRun& run : runs) {
    lengths.push_back(run.length);
    samples += run.length;
  }
  std::sort(lengths.begin(), lengths.end());
  std::size_t seen = 0;
  for (const std::size_t length : lengths) {
    seen += length;
    if (static_cast<double>(seen) >= fraction * static_cast<double>(samples))
      return static_cast<double>(length);
  }
  return 0.0;
}

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto count = static_cast<double>(x.size());
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / count;
    mean_y += y[i] / count;
  }
  double xx = 0.0;
  double xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  const double slope = xx > 0.0 ? xy / xx : 0.0;
  return {slope, mean_y - slope * mean_x};
}

std::vector<double> without_line(std::vector<double> values) {
  std::vector<double> place(values.size());
  std::iota(place.begin(), place.end(), 0.0);
  const Line line = fit_line(place, values);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= line.offset + line.slope * place[i];
  return values;
}

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin(), x.end(), at);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(above - x.begin());
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

}  // namespace wheel_twin::logs
