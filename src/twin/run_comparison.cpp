#include "twin/run_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "rig/replay.h"
#include "rig/semi_empirical_contact.h"
#include "twin/fluctuation.h"
#include "twin/run_grid.h"
#include "twin/simulate.h"
#include "twin/steady_runs.h"

namespace wheel_twin::twin {
namespace {

// Means over a window that is centred on each sample and shorter at the ends.
std::vector<double> low_passed(const std::vector<double>& time, const std::vector<double>& value,
                               double window) {
  std::vector<double> result(value.size());
  std::size_t first = 0, last = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    while (last < value.size() && time[last] <= time[i] + 0.5 * window) sum += value[last++];
    while (time[first] < time[i] - 0.5 * window) sum -= value[first++];
    result[i] = sum / static_cast<double>(last - first);
  }
  return result;
}

struct Interval {
  double start = 0.0;
  double end = 0.0;
  bool has(double time) const { return time >= start && time <= end; }
};

/// When the rig moved steadily, from the wheel's touch of the soil.
class Steady {
 public:
  Steady(const RunGrid& grid, double start, double touch) : grid_(grid), start_(start), touch_(touch) {}
  bool has(double time) const {
    if (time < touch_) return false;
    const auto bin = static_cast<std::ptrdiff_t>(std::floor((time - start_) / grid_.bin));
    return bin >= 0 && bin < grid_.bins() && grid_.moving[static_cast<std::size_t>(bin)];
  }

 private:
  const RunGrid& grid_;
  double start_, touch_;
};

// When the wheel was last above the soil: before, it hung, and the twin, which stands on the soil, says
// nothing about it.
double touch_time(const run_log::ScalarSeries& draw_wire) {
  constexpr double hanging = -0.5e-3;  // m; more than the encoder's noise about first touch
  double touch = -1e300;
  for (std::size_t i = 0; i < draw_wire.time.size(); ++i)
    if (draw_wire.value[i] < hanging) touch = draw_wire.time[i];
  return touch;
}

void drop_before(double time, SeriesComparison& series) {
  const auto count = std::lower_bound(series.time.begin(), series.time.end(), time) - series.time.begin();
  for (auto* values : {&series.time, &series.measured, &series.twin})
    values->erase(values->begin(), values->begin() + count);
}

std::vector<double> window_times(const Interval& window) {
  constexpr double spacing = 0.05;
  std::vector<double> times;
  for (int i = 0; window.start + spacing * i <= window.end; ++i) times.push_back(window.start + spacing * i);
  return times;
}

std::vector<double> merged(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  std::sort(a.begin(), a.end());
  a.erase(std::unique(a.begin(), a.end()), a.end());
  return a;
}

struct Series {
  std::vector<double> time;
  std::vector<double> value;
};

template <typename Times>
double mean_over(const Series& series, const Times& interval) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < series.time.size(); ++i)
    if (interval.has(series.time[i])) sum += series.value[i], count += 1.0;
  return count > 0.0 ? sum / count : std::nan("");
}

double wrench_part(const rig::WrenchReading& reading, Channel channel) {
  switch (channel) {
    case Channel::drawbar_pull:
      return reading.force.x();
    case Channel::side_force:
      return reading.force.y();
    case Channel::normal_load:
      return reading.force.z();
    default:
      return reading.torque.y();
  }
}

bool is_wrench(Channel channel) {
  return channel != Channel::hub_displacement && channel != Channel::motor_effort;
}

// The twin's readings of a channel at all stamps that were asked for.
Series twin_series(Channel channel, const rig::Prediction& prediction, const rig::SampleTimes& times) {
  Series series;
  if (is_wrench(channel)) {
    series.time = times.wrench;
    for (const auto& reading : prediction.wrench) series.value.push_back(wrench_part(reading, channel));
  } else if (channel == Channel::hub_displacement) {
    series = {times.displacement, prediction.displacement};
  } else {
    series = {times.effort, prediction.effort};
  }
  return series;
}

Series measured_series(Channel channel, const run_log::RunLog& log) {
  Series series;
  if (channel == Channel::hub_displacement) {
    series = {log.draw_wire.time, log.draw_wire.value};
  } else if (channel == Channel::motor_effort) {
    if (!log.joints.wheel_effort.empty()) series = {log.joints.time, log.joints.wheel_effort};
  } else {
    series.time = log.ft.time;
    for (std::size_t i = 0; i < log.ft.time.size(); ++i)
      series.value.push_back(wrench_part({log.ft.force[i], log.ft.torque[i]}, channel));
  }
  return series;
}

// The twin's values at the stamps of `measured`, which are among its own.
SeriesComparison paired(const Series& measured, const Series& twin) {
  SeriesComparison result;
  std::size_t j = 0;
  for (std::size_t i = 0; i < measured.time.size(); ++i) {
    while (j + 1 < twin.time.size() && twin.time[j] < measured.time[i]) ++j;
    result.time.push_back(measured.time[i]);
    result.measured.push_back(measured.value[i]);
    result.twin.push_back(twin.value[j]);
  }
  return result;
}

rig::RunConditions conditions_of(const RunComparison& comparison) {
  rig::RunConditions conditions;
  conditions.slip = comparison.run.slip;
  conditions.load = comparison.load;
  conditions.wheel_speed = comparison.run.wheel_speed;
  conditions.steering_angle = leading_steering(comparison.run);
  return conditions;
}

rig::Prediction predict(const TwinConfig& model, const rig::RunConditions& conditions,
                        const rig::MotionSeries& motion, const rig::SampleTimes& times,
                        const ComparisonOptions& options) {
  const Acting acting = acting_effects(model);
  rig::SemiEmpiricalOptions contact_options;
  contact_options.start_up = model.start_up;
  rig::SemiEmpiricalContact contact(model.wheel, model.soil, acting.ports, contact_options);
  rig::ReplayOptions replay;
  replay.step = options.step;
  return rig::predict(model.rig, conditions, model.wheel.radius, contact, acting.ports, motion, times,
                      replay);
}

/// The empirical corrections of a twin, while the rig moves steadily.
void correct(const TwinConfig& model, const rig::RunConditions& conditions, Channel channel,
             const Steady& in_motion, Series& series) {
  for (const Correction& correction : model.corrections) {
    if (correction.channel != channel) continue;
    const double value = correction.at(conditions.slip, conditions.load);
    for (std::size_t i = 0; i < series.time.size(); ++i)
      if (in_motion.has(series.time[i])) series.value[i] += value;
  }
}

void compare_log(const TwinConfig& model, const run_log::RunLog& log, const ComparisonOptions& options,
                 RunComparison& comparison) {
  const rig::RunConditions conditions = conditions_of(comparison);
  const rig::MotionSeries motion = rig::motion_of_log(log, conditions);
  const double start = motion.front().time;
  Interval window;
  rig::SampleTimes times{log.ft.time, log.draw_wire.time, {}};
  if (!log.joints.wheel_effort.empty()) times.effort = log.joints.time;
  const auto& averages = comparison.run.averages;
  if (averages) {
    window = {start + averages->window_start, start + averages->window_end};
    if (window.end > motion.back().time + 0.1)
      throw Error(fmt::format("the averages are over {:.1f} to {:.1f} s, the log ends at {:.1f} s",
                              averages->window_start, averages->window_end, motion.back().time - start));
    const std::vector<double> extra = window_times(window);
    times.wrench = merged(times.wrench, extra);
    times.displacement = merged(times.displacement, extra);
    if (averages->motor_effort) times.effort = merged(times.effort, extra);
  }
  const rig::Prediction prediction = predict(model, conditions, motion, times, options);
  const double touch = touch_time(log.draw_wire);
  const RunGrid grid = grid_of(comparison.run, comparison.name, log, model.wheel.radius);
  const Steady in_motion(grid, first_stamp(log), touch);
  for (const Channel channel : all_channels) {
    if (channel == Channel::normal_load && comparison.measured_load) continue;
    Series twin = twin_series(channel, prediction, times);
    correct(model, conditions, channel, in_motion, twin);
    Series measured = measured_series(channel, log);
    const logs::Average* average = nullptr;
    if (averages && window_average(*averages, channel)) average = &*window_average(*averages, channel);
    if (twin.time.empty() || (measured.time.empty() && average == nullptr)) continue;
    ChannelComparison result;
    if (!measured.time.empty()) result.series = paired(measured, twin);
    if (average != nullptr) {
      result.mean = {average->mean, mean_over(twin, window)};
      result.error = std::abs(result.mean.twin - result.mean.measured);
      result.from_average = true;
    } else {
      const Series twin_there{result.series->time, result.series->twin};
      const std::vector<double> a = low_passed(measured.time, measured.value, options.low_pass);
      const std::vector<double> b = low_passed(twin_there.time, twin_there.value, options.low_pass);
      double sum = 0.0, count = 0.0;
      for (std::size_t i = 0; i < a.size(); ++i)
        if (in_motion.has(measured.time[i])) sum += (a[i] - b[i]) * (a[i] - b[i]), count += 1.0;
      if (count == 0.0) continue;
      result.mean = {mean_over(measured, in_motion), mean_over(twin_there, in_motion)};
      result.error = std::sqrt(sum / count);
    }
    if (result.series) {
      drop_before(touch, *result.series);
      for (double& time : result.series->time) time -= start;
    }
    comparison.channels[index_of(channel)] = std::move(result);
  }
}

/// Averages alone: the steady state at the declared slip.
void compare_averages(const TwinConfig& model, RunComparison& comparison) {
  const SteadyRun run = steady_run(comparison.run, comparison.name, model.wheel.radius);
  const std::vector<double> means = predict_means(model, run);
  for (std::size_t w = 0; w < means.size(); ++w) {
    const WindowMean& window = run.grid.windows[w];
    if (window.channel == Channel::normal_load && comparison.measured_load) continue;
    ChannelComparison result;
    result.mean = {window.mean, means[w]};
    result.error = std::abs(result.mean.twin - result.mean.measured);
    result.from_average = true;
    comparison.channels[index_of(window.channel)] = std::move(result);
  }
}

}  // namespace

RunComparison compare_run(const TwinConfig& model, const logs::Run& run, const std::string& name,
                          const run_log::RunLog* log, const ComparisonOptions& options) {
  RunComparison comparison;
  comparison.name = name;
  comparison.run = run;
  comparison.measured_load = run.averages && run.averages->normal_load;
  comparison.load = leading_load(run);
  const TwinConfig loose = without_friction(model);
  try {
    if (log != nullptr && !log->joints.time.empty())
      compare_log(loose, *log, options, comparison);
    else if (run.averages)
      compare_averages(loose, comparison);
    else
      comparison.failure =
          "the bag has no joint states, so no motion to lead the twin, and there are no averages";
  } catch (const Error& error) {
    comparison.channels = {};
    comparison.failure = error.what();
  }
  return comparison;
}

}  // namespace wheel_twin::twin
