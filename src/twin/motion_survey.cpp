#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "logs/statistics.h"
#include "twin/log_survey.h"

namespace wheel_twin::twin {
namespace {

constexpr double two_pi = 6.283185307179586;
constexpr int most_cycles = 60;      // a turn that are looked at
constexpr double moving = 1e-3;      // m/s
constexpr double least_turns = 0.6;  // of a run for its lines to be looked at

struct Summary {
  double mean = 0.0, error = 0.0;
};
Summary summary(const std::vector<double>& values) {
  Summary s;
  const double n = static_cast<double>(values.size());
  s.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double square = 0.0;
  for (const double v : values) square += (v - s.mean) * (v - s.mean);
  s.error = n > 1.0 ? std::sqrt(square / (n - 1.0) / n) : 0.0;
  return s;
}

/// Travelled over integrated speed, while it moves; NaN when it hardly does.
double scale_of(const std::vector<double>& time, const std::vector<double>& position,
                const std::vector<double>& speed, double least_travel) {
  double integral = 0.0;
  for (std::size_t i = 1; i < time.size(); ++i)
    integral += 0.5 * (speed[i] + speed[i - 1]) * (time[i] - time[i - 1]);
  if (std::abs(integral) < least_travel) return std::nan("");
  return (position.back() - position.front()) / integral;
}

SurveyItem item(const char* place, std::string what, const Summary& s, const char* unit, std::string evidence,
                double negligible) {
  return {place,
          std::move(what),
          s.mean,
          s.error,
          unit,
          std::move(evidence),
          std::abs(s.mean) > std::max(3.0 * s.error, negligible)};
}

}  // namespace

void MotionSurvey::add_lines(std::vector<Line>& lines, const std::vector<double>& angle,
                             const std::vector<double>& value) const {
  if (angle.size() < 400 || std::abs(angle.back() - angle.front()) < least_turns * two_pi) return;
  if (lines.empty())
    for (int k = 1; k <= most_cycles; ++k) lines.push_back({static_cast<double>(k), {}, {}});
  // A running mean over one period is taken off first, so that a slow course is no line.
  const double spacing = std::abs(angle.back() - angle.front()) / static_cast<double>(angle.size());
  for (Line& line : lines) {
    const auto half = static_cast<std::size_t>(std::max(2.0, 0.5 * two_pi / line.cycles / spacing));
    if (4 * half > angle.size()) continue;
    double cc = 0.0, ss = 0.0, cs = 0.0, cv = 0.0, sv = 0.0, vv = 0.0, n = 0.0;
    double sum =
        std::accumulate(value.begin(), value.begin() + static_cast<std::ptrdiff_t>(2 * half + 1), 0.0);
    for (std::size_t i = half; i + half < angle.size(); ++i) {
      if (i > half) sum += value[i + half] - value[i - half - 1];
      const double v = value[i] - sum / static_cast<double>(2 * half + 1);
      const double c = std::cos(line.cycles * angle[i]), s = std::sin(line.cycles * angle[i]);
      cc += c * c, ss += s * s, cs += c * s, cv += c * v, sv += s * v, vv += v * v, n += 1.0;
    }
    const double det = cc * ss - cs * cs;
    if (det <= 0.0 || n < 50.0) continue;
    const double a = (cv * ss - sv * cs) / det, b = (sv * cc - cv * cs) / det;
    const double left = std::max(0.0, vv - a * cv - b * sv) / n;
    line.amplitude.push_back(std::hypot(a, b));
    // Neighbouring samples go along: about one in five is independent.
    line.noise.push_back(std::sqrt(2.0 * left / (0.2 * n)));
  }
}

void MotionSurvey::add(const logs::Run& run, const run_log::RunLog& log) {
  const run_log::JointSeries& j = log.joints;
  if (j.time.size() < 10) return;
  const double carriage = scale_of(j.time, j.carriage_position, j.carriage_velocity, 0.05);
  const double wheel = scale_of(j.time, j.wheel_angle, j.wheel_rate, 0.05 / radius_);
  if (std::isfinite(carriage)) carriage_scale_.push_back(carriage - 1.0);
  if (std::isfinite(wheel)) wheel_scale_.push_back(wheel - 1.0);
  std::vector<double> gaps;
  for (std::size_t i = 1; i < j.time.size(); ++i) gaps.push_back(j.time[i] - j.time[i - 1]);
  step_.push_back(logs::quantile(gaps, 0.5));
  gap_.push_back(*std::max_element(gaps.begin(), gaps.end()));

  // The last third of the motion is steady.
  std::size_t last = j.time.size();
  while (last > 0 && std::max(std::abs(j.carriage_velocity[last - 1]),
                              radius_ * std::abs(j.wheel_rate[last - 1])) < moving)
    --last;
  const std::size_t first = last - last / 3;
  std::vector<double> angle, rim;
  for (std::size_t i = first; i < last; ++i) {
    angle.push_back(j.wheel_angle[i]);
    rim.push_back(radius_ * j.wheel_rate[i]);
  }
  if (run.slip < -0.98 && !rim.empty()) {
    locked_speed_.push_back(std::accumulate(rim.begin(), rim.end(), 0.0) / static_cast<double>(rim.size()));
    const auto peak = std::minmax_element(rim.begin(), rim.end());
    locked_peak_.push_back(*peak.second - *peak.first);
  }
  add_lines(rim_lines_, angle, rim);
  const run_log::ScalarSeries& z = log.draw_wire;
  if (last > first && z.time.size() > 100) {
    std::vector<double> hub, hub_angle;
    for (std::size_t i = 0; i < z.time.size(); ++i)
      if (z.time[i] >= j.time[first] && z.time[i] <= j.time[last - 1]) {
        hub.push_back(z.value[i]);
        hub_angle.push_back(logs::interpolate(j.time, j.wheel_angle, z.time[i]));
      }
    add_lines(hub_lines_, hub_angle, hub);
    // The way along which the sinkage approaches its end: from the start of the steady speeds to where 63 %
    // of the rest of the way down is made.
    if (hub.size() > 10) {
      const double end =
          std::accumulate(hub.end() - static_cast<std::ptrdiff_t>(hub.size() / 4), hub.end(), 0.0) /
          static_cast<double>(hub.size() / 4);
      const double final_rim = rim[rim.size() / 2];
      std::size_t start = last - 1;
      while (start > 0 && std::abs(radius_ * j.wheel_rate[start] - final_rim) <
                              std::max(1.5e-3, 0.2 * std::abs(final_rim)))
        --start;
      const double from = logs::interpolate(z.time, z.value, j.time[start]);
      if (end - from > 2e-3)
        for (std::size_t i = 0; i < z.time.size(); ++i)
          if (z.time[i] > j.time[start] && z.value[i] > from + 0.632 * (end - from)) {
            const double faster =
                std::max(std::abs(j.carriage_velocity[last / 2 + start / 2]), std::abs(final_rim));
            settling_.push_back(faster * (z.time[i] - j.time[start]));
            break;
          }
    }
  }
  if (log.ft.time.size() > 400) {
    std::vector<double> pull, pull_angle;
    for (std::size_t i = 0; i < log.ft.time.size(); ++i)
      if (log.ft.time[i] >= j.time[first] && log.ft.time[i] <= j.time[last - 1]) {
        pull.push_back(log.ft.force[i].x());
        pull_angle.push_back(logs::interpolate(j.time, j.wheel_angle, log.ft.time[i]));
      }
    add_lines(pull_lines_, pull_angle, pull);
  }
}

void MotionSurvey::report_lines(const std::vector<Line>& lines, const std::string& what,
                                const std::string& unit, double factor, std::vector<SurveyItem>& items) {
  struct Strong {
    double cycles, amplitude, error, ratio;
    std::size_t runs;
  };
  std::vector<Strong> strong;
  std::vector<double> typical;  // median amplitude of each
  for (const Line& line : lines) typical.push_back(logs::quantile(line.amplitude, 0.5));
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const Line& line = lines[k];
    if (line.amplitude.size() < 3) continue;
    // In most runs above what noise makes of it, and above the lines beside it: a red spectrum is no line.
    std::vector<double> ratios, beside;
    for (std::size_t i = 0; i < line.amplitude.size(); ++i)
      ratios.push_back(line.amplitude[i] / std::max(1e-12, line.noise[i]));
    for (std::size_t other = k >= 4 ? k - 4 : 0; other < std::min(lines.size(), k + 5); ++other)
      if (other != k && std::isfinite(typical[other])) beside.push_back(typical[other]);
    const double ratio = logs::quantile(ratios, 0.5);
    if (ratio < 2.5 || typical[k] < 2.0 * logs::quantile(beside, 0.5) ||
        typical[k] < 1.2 * logs::quantile(beside, 1.0))
      continue;
    const Summary s = summary(line.amplitude);
    strong.push_back({line.cycles, s.mean, s.error, ratio, line.amplitude.size()});
  }
  std::stable_sort(strong.begin(), strong.end(),
                   [](const Strong& a, const Strong& b) { return a.ratio > b.ratio; });
  if (strong.size() > 4) strong.resize(4);
  for (const Strong& line : strong)
    items.push_back(
        {"wheel", fmt::format("{} has a line {:.0f} times a turn of the wheel", what, line.cycles),
         factor * line.amplitude, factor * line.error, unit,
         fmt::format("amplitude, {:.1f} times its noise in the median of {} runs", line.ratio, line.runs),
         true});
  for (const Line& line : lines)
    if (line.cycles == 1.0 && line.amplitude.size() >= 3 &&
        std::none_of(strong.begin(), strong.end(), [](const Strong& s) { return s.cycles == 1.0; })) {
      const Summary s = summary(line.amplitude), noise = summary(line.noise);
      items.push_back(
          {"wheel", fmt::format("{} once a turn (eccentric wheel): not beyond noise", what), factor * s.mean,
           factor * noise.mean, unit,
           fmt::format("amplitude over {} runs of at least {:.1f} turns", line.amplitude.size(), least_turns),
           false});
    }
}

void MotionSurvey::report(std::vector<SurveyItem>& items) const {
  const auto runs = [](const std::vector<double>& v) { return fmt::format("{} runs", v.size()); };
  if (carriage_scale_.size() >= 2)
    items.push_back(item("sensor", "carriage: position travels further than the logged speed says by",
                         summary(carriage_scale_), "fraction", runs(carriage_scale_), 0.002));
  if (wheel_scale_.size() >= 2)
    items.push_back(item("sensor", "wheel: angle turns further than the logged rate says by",
                         summary(wheel_scale_), "fraction", runs(wheel_scale_), 0.002));
  const auto reads = [](double v) { return v != 0.0; };
  if (std::any_of(locked_peak_.begin(), locked_peak_.end(), reads)) {
    items.push_back(item("sensor", "locked wheel: the rim speed still reads", summary(locked_speed_), "m/s",
                         runs(locked_speed_), 1e-4));
    items.push_back(item("sensor", "locked wheel: from lowest to highest reading of the rim speed",
                         summary(locked_peak_), "m/s", runs(locked_peak_), 1e-4));
  }
  report_lines(rim_lines_, "rim speed", "mm/s", 1e3, items);
  report_lines(hub_lines_, "hub displacement", "mm", 1e3, items);
  report_lines(pull_lines_, "drawbar pull", "N", 1.0, items);
  if (settling_.size() >= 3)
    items.push_back(item("soil", "sinkage comes in along a way of (to 63 %)", summary(settling_), "m",
                         runs(settling_) + " that sank by more than 2 mm", 1e-3));
  if (!step_.empty()) {
    const Summary s = summary(step_);
    items.push_back({"log", "joint states come every", s.mean, s.error, "s", runs(step_), false});
    const double worst = *std::max_element(gap_.begin(), gap_.end());
    items.push_back(
        {"log", "longest gap between joint states", worst, 0.0, "s", runs(gap_), worst > 5.0 * s.mean});
  }
}

}  // namespace wheel_twin::twin
