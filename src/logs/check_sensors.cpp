// Rules on sensors: stuck, saturated, a tare that is off or drifts.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "logs/check_rules.h"
#include "logs/statistics.h"
#include "logs/topics.h"

namespace wheel_twin::logs::rules {
namespace {

// A force sensor is never still: a whole wrench that repeats itself for so long is not measured. A real
// driver was seen to hold one for 0.09 s.
constexpr double still_wrench = 0.5;   // s
constexpr double still_channel = 2.0;  // s
constexpr double load_change = 0.3;    // of the range of the load in the log, while a displacement rests
// Before it got stuck, a sensor with noise changes its value at more than this share of its samples.
constexpr double lively = 0.4;
// A value at the end of the range for so many samples in a row, and so many times longer than the channel
// else rests.
constexpr std::size_t flat_samples = 20;
constexpr double flat_ratio = 3.0;
// Ranges of ATI Mini45's three calibrations (data sheet 9105-TIF: SI-145-5, SI-290-10, SI-580-20).
constexpr std::array<double, 3> force_ranges{145.0, 290.0, 580.0};
constexpr std::array<double, 3> axial_ranges{290.0, 580.0, 1160.0};
constexpr std::array<double, 3> torque_ranges{5.0, 10.0, 20.0};
constexpr double range_tolerance = 0.001;
constexpr std::size_t at_range_samples = 10;  // a driver that repeats its readings makes fewer by chance
constexpr double hanging = -0.001;  // m: the hub is above first touch by more than this, the wheel is free
constexpr double tare_force = 0.5;  // N, and share of the load
constexpr double tare_share = 0.03;
constexpr double carrying_share =
    0.5;  // of the load: then the wheel does not hang, and the displacement is wrong
constexpr double drift_force = 0.5;  // N over the steady part, and share of the load
constexpr double drift_share = 0.01;
constexpr double drift_certainty = 6.0;  // times the scatter of the blocks' medians about the line
constexpr double drift_span = 10.0;      // s; a shorter steady part shows no drift
constexpr int drift_blocks = 12;

bool near_range(double value, const std::array<double, 3>& ranges) {
  return std::any_of(ranges.begin(), ranges.end(),
                     [&](double range) { return std::abs(std::abs(value) / range - 1.0) < range_tolerance; });
}

/// Share of samples that differ from the one before, over `span` seconds before sample `end`.
double liveliness(const Channel& channel, std::size_t end, double span) {
  std::size_t changes = 0;
  std::size_t samples = 0;
  for (std::size_t i = end; i > 1 && channel.time[end] - channel.time[i - 1] < span; --i) {
    ++samples;
    if (channel.value[i - 1] != channel.value[i - 2]) ++changes;
  }
  return samples < 10 ? 0.0 : static_cast<double>(changes) / static_cast<double>(samples);
}

void check_channel(const Channel& channel, const std::array<double, 3>* ranges,
                   std::pair<double, double> moving, Findings& findings) {
  if (channel.value.size() < 2 * flat_samples) return;
  const auto [low, high] = std::minmax_element(channel.value.begin(), channel.value.end());
  const std::vector<EqualRun> runs = equal_runs(channel.value);
  std::size_t longest = 0;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (runs[i].length > runs[longest].length) longest = i;
  for (const double extreme : {*low, *high}) {
    if (extreme == 0.0 || *low == *high) continue;
    std::vector<EqualRun> others;
    std::size_t count = 0;
    EqualRun flat;
    for (const EqualRun& run : runs) {
      if (channel.value[run.begin] != extreme) {
        others.push_back(run);
        continue;
      }
      count += run.length;
      if (run.length > flat.length) flat = run;
    }
    const bool at_range = ranges != nullptr && near_range(extreme, *ranges) && count >= at_range_samples;
    const bool is_flat = flat.length >= flat_samples && flat.begin + flat.length < channel.value.size() &&
                         static_cast<double>(flat.length) > flat_ratio * run_length_quantile(others, 0.95) &&
                         liveliness(channel, flat.begin, still_channel) > lively;
    if (at_range || is_flat)
      findings.error("saturated", channel.topic, count, channel.time[flat.begin],
                     fmt::format("{} stands at its {} of {:.6g}: saturated", channel.name,
                                 extreme == *low ? "least" : "most", extreme));
  }
  const EqualRun& run = runs[longest];
  const double begin = channel.time[run.begin];
  const double end = channel.time[run.begin + run.length - 1];
  if (end - begin < still_channel || channel.value[run.begin] == 0.0) return;
  if (std::min(end, moving.second) - std::max(begin, moving.first) < still_channel) return;
  if (run.begin > 0 && liveliness(channel, run.begin, still_channel) > lively)
    findings.error("stuck", channel.topic, run.length, begin,
                   fmt::format("{} stays at exactly {:.6g} for {:.3g} s while the wheel moves: stuck",
                               channel.name, channel.value[run.begin], end - begin));
}

void check_still_wrench(const run_log::WrenchSeries& ft, Findings& findings) {
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= ft.time.size(); ++i) {
    if (i < ft.time.size() && ft.force[i] == ft.force[begin] && ft.torque[i] == ft.torque[begin]) continue;
    if (ft.time[i - 1] - ft.time[begin] >= still_wrench) {
      findings.error(
          "stuck", wrench_topic, i - begin, ft.time[begin],
          fmt::format("the wrench repeats itself for {:.3g} s: stuck", ft.time[i - 1] - ft.time[begin]));
      return;
    }
    begin = i;
  }
}

/// Of a pressing: the displacement rests while the load changes.
void check_still_displacement(const run_log::RunLog& log, Findings& findings) {
  if (log.ft.time.empty()) return;
  const std::vector<double> normal = force_axis(log, 2);
  const double range = quantile(normal, 0.98) - quantile(normal, 0.02);
  for (const EqualRun& run : equal_runs(log.draw_wire.value)) {
    const double begin = log.draw_wire.time[run.begin];
    const double end = log.draw_wire.time[run.begin + run.length - 1];
    if (end - begin < still_channel) continue;
    const double change = interpolate(log.ft.time, normal, end) - interpolate(log.ft.time, normal, begin);
    if (std::abs(change) > load_change * range)
      findings.error(
          "stuck", displacement_topic, run.length, begin,
          fmt::format(
              "displacement stays at exactly {:.6g} m for {:.3g} s while Fz changes by {:.4g} N: stuck",
              log.draw_wire.value[run.begin], end - begin, change));
  }
}

}  // namespace

void check_stuck_and_saturated(const run_log::RunLog& log, Findings& findings) {
  const auto moving = steady_part(log);
  check_still_wrench(log.ft, findings);
  const std::array<const char*, 3> forces{"Fx, N", "Fy, N", "Fz, N"};
  const std::array<const char*, 3> torques{"Tx, N m", "Ty, N m", "Tz, N m"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    check_channel({wrench_topic, forces[axis], log.ft.time, force_axis(log, static_cast<int>(axis))},
                  axis == 2 ? &axial_ranges : &force_ranges, moving, findings);
    check_channel({wrench_topic, torques[axis], log.ft.time, torque_axis(log, static_cast<int>(axis))},
                  &torque_ranges, moving, findings);
  }
  if (std::isfinite(moving.first))
    check_channel({displacement_topic, "displacement, m", log.draw_wire.time, log.draw_wire.value}, nullptr,
                  moving, findings);
  else
    check_still_displacement(log, findings);
}

void check_tare(const run_log::RunLog& log, const Declared& declared, Findings& findings) {
  const run_log::WrenchSeries& ft = log.ft;
  if (ft.time.empty() || declared.pressing) return;
  const auto part = steady_part(log);
  const std::vector<double> normal = force_axis(log, 2);
  const double load = std::abs(median_in(ft.time, normal, part));
  if (!log.draw_wire.time.empty()) {
    const std::array<const char*, 3> names{"Fx", "Fy", "Fz"};
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double> force = force_axis(log, axis);
      std::vector<double> free;
      double first = 0.0;
      // Until first touch: later the soil may lie higher than there.
      for (std::size_t i = 0; i < force.size(); ++i) {
        if (interpolate(log.draw_wire.time, log.draw_wire.value, ft.time[i]) >= hanging) break;
        if (free.empty()) first = ft.time[i];
        free.push_back(force[i]);
      }
      const double zero = median(free);
      if (free.size() >= flat_samples && std::abs(zero) > std::max(tare_force, tare_share * load) &&
          std::abs(zero) < carrying_share * load)
        findings.warning("tare", wrench_topic, free.size(), first,
                         fmt::format("{} reads {:.3g} N while the wheel hangs free: the tare is off",
                                     names[static_cast<std::size_t>(axis)], zero));
    }
  }
  // On a free slide the load is the dead weight: in the steady part it may vary, but not run away.
  const double span = part.second - part.first;
  if (!(span > drift_span)) return;
  std::vector<double> time;
  std::vector<double> mean;
  for (int block = 0; block < drift_blocks; ++block) {
    const double begin = part.first + span * block / drift_blocks;
    const double value = median_in(ft.time, normal, {begin, begin + span / drift_blocks});
    if (!std::isfinite(value)) continue;
    time.push_back(begin + 0.5 * span / drift_blocks);
    mean.push_back(value);
  }
  if (time.size() < drift_blocks / 2) return;
  const Line line = fit_line(time, mean);
  double scatter = 0.0;
  for (std::size_t i = 0; i < time.size(); ++i)
    scatter +=
        std::pow(mean[i] - line.offset - line.slope * time[i], 2) / static_cast<double>(time.size() - 2);
  const double drift = line.slope * span;
  if (std::abs(drift) > std::max(drift_force, drift_share * load) &&
      std::abs(drift) > drift_certainty * std::sqrt(scatter))
    findings.warning(
        "drift", wrench_topic, 1, part.first,
        fmt::format("Fz drifts by {:+.3g} N in {:.3g} s under a constant dead weight: the tare drifts", drift,
                    span));
}

}  // namespace wheel_twin::logs::rules
