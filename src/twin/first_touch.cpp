#include "twin/first_touch.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace wheel_twin::twin {
namespace {

constexpr std::size_t fewest = 6;    // samples of a hanging wheel
constexpr double shows = 0.01;       // of the load that it will carry
constexpr double above_noise = 4.0;  // deviations of the hanging wheel's load
constexpr double slowest = 5e-4;     // m/s of lowering

/// Linear between samples, held beyond them.
double at(const run_log::ScalarSeries& series, double time) {
  const auto after = std::lower_bound(series.time.begin(), series.time.end(), time);
  const auto k = static_cast<std::size_t>(after - series.time.begin());
  if (k == 0) return series.value.front();
  if (k == series.time.size()) return series.value.back();
  const double share = (time - series.time[k - 1]) / (series.time[k] - series.time[k - 1]);
  return series.value[k - 1] + share * (series.value[k] - series.value[k - 1]);
}

}  // namespace

std::optional<FirstTouch> first_touch(const run_log::RunLog& log) {
  const std::size_t n = log.ft.time.size();
  if (n < 10 * fewest || log.draw_wire.time.size() < 10 * fewest) return std::nullopt;
  std::vector<double> sorted(n);
  for (std::size_t i = 0; i < n; ++i) sorted[i] = log.ft.force[i].z();
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2), sorted.end());
  const double carried = sorted[n / 2];
  if (!(carried > 0.0)) return std::nullopt;
  double sum = 0.0, square = 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double load = log.ft.force[i].z();
    if (i >= fewest) {
      const auto count = static_cast<double>(i);
      const double mean = sum / count;
      const double deviation = std::sqrt(std::max(0.0, square / count - mean * mean));
      const double least = mean + std::max(shows * carried, above_noise * deviation);
      if (load > least && log.ft.force[i + 1].z() > least) {
        const double start = log.ft.time.front(), end = log.ft.time[i];
        FirstTouch touch;
        touch.displacement = at(log.draw_wire, end);
        touch.speed = (touch.displacement - at(log.draw_wire, start)) / (end - start);
        if (!(touch.speed > slowest)) return std::nullopt;
        return touch;
      }
    }
    if (std::abs(load) > 0.2 * carried) return std::nullopt;  // it does not hang free
    sum += load;
    square += load * load;
  }
  return std::nullopt;
}

}  // namespace wheel_twin::twin
