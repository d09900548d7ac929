#include "twin/run_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "logs/bag_reader.h"
#include "rig/speeds.h"

namespace wheel_twin::twin {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Adds samples to bins and averages; an empty bin between filled ones is interpolated (a slow sensor),
/// others stay missing.
class Binning {
 public:
  Binning(double start, double bin, int bins)
      : start_(start), bin_(bin), sum_(Eigen::VectorXd::Zero(bins)), count_(Eigen::VectorXd::Zero(bins)) {}

  void add(double time, double value) {
    const int i = static_cast<int>(std::floor((time - start_) / bin_));
    if (i < 0 || i >= sum_.size()) return;
    sum_[i] += value;
    count_[i] += 1.0;
  }

  Eigen::VectorXd means() const {
    Eigen::VectorXd result = Eigen::VectorXd::Constant(sum_.size(), missing);
    int last = -1;
    for (int i = 0; i < sum_.size(); ++i) {
      if (count_[i] == 0.0) continue;
      result[i] = sum_[i] / count_[i];
      const int gap = i - last;
      if (last >= 0 && gap > 1 && gap * bin_ <= longest_gap)
        for (int j = last + 1; j < i; ++j)
          result[j] = result[last] + (result[i] - result[last]) * (j - last) / gap;
      last = i;
    }
    return result;
  }

 private:
  static constexpr double longest_gap = 1.0;  // s
  double start_, bin_;
  Eigen::VectorXd sum_, count_;
};

void mask_changes_of_speed(RunGrid& grid, double radius) {
  const int n = grid.bins();
  double fastest = 0.0;
  for (const auto& m : grid.motion)
    fastest = std::max({fastest, std::abs(m.carriage_velocity), std::abs(radius * m.wheel_rate)});
  const double step = 0.15 * fastest;
  std::vector<bool> masked(static_cast<std::size_t>(n), false);
  for (int i = 1; i < n; ++i) {
    const auto& a = grid.motion[static_cast<std::size_t>(i - 1)];
    const auto& b = grid.motion[static_cast<std::size_t>(i)];
    const double change = std::max(std::abs(a.carriage_velocity - b.carriage_velocity),
                                   radius * std::abs(a.wheel_rate - b.wheel_rate));
    if (fastest > 0.0 && change > step)
      for (int j = i - 1; j <= std::min(n - 1, i + 1); ++j) masked[static_cast<std::size_t>(j)] = true;
  }
  grid.moving.assign(static_cast<std::size_t>(n), false);
  // A bin in or beside slow motion is neither at rest nor moving: slip there is a ratio of vanishing speeds.
  constexpr double moves = 0.2, stands = 0.02;  // of the largest speed
  const auto share = [&](int i) {
    const auto& m = grid.motion[static_cast<std::size_t>(std::clamp(i, 0, n - 1))];
    return std::max(std::abs(m.carriage_velocity), std::abs(radius * m.wheel_rate)) / fastest;
  };
  for (int i = 0; i < n && fastest > 0.0; ++i) {
    const auto k = static_cast<std::size_t>(i);
    grid.moving[k] = !masked[k] && share(i) > moves;
    if (masked[k] || (!grid.moving[k] && std::max({share(i - 1), share(i), share(i + 1)}) > stands))
      grid.measured.col(i).setConstant(missing);
  }
}

/// A wheel that is still being let down, or is lifted again, is no wheel at rest under its load: bins before
/// the first motion in which hub and load have not come to where they stand before it (all of them, when no
/// two bins agree), and the like after the last.
void mask_settling(RunGrid& grid) {
  constexpr double settled = 0.01;  // of the displacement and of the load
  const auto hub = grid.measured.row(index_of(Channel::hub_displacement)).eval(),
             load = grid.measured.row(index_of(Channel::normal_load)).eval();
  const int n = grid.bins();
  const auto first_moving = std::find(grid.moving.begin(), grid.moving.end(), true);
  if (first_moving == grid.moving.end()) return;
  const int first = static_cast<int>(first_moving - grid.moving.begin());
  int last = n - 1;
  while (!grid.moving[static_cast<std::size_t>(last)]) --last;
  const auto mask = [&](int begin, int end, int step) {  // from the motion outwards
    int standing = begin;
    while (standing != end && !std::isfinite(hub[standing]) && !std::isfinite(load[standing]))
      standing += step;
    const auto stands = [&](const auto& values, int i) {
      return !(std::abs(values[i] - values[standing]) > settled * std::abs(values[standing]));
    };
    int gone = standing;
    while (gone != end && stands(hub, gone) && stands(load, gone)) gone += step;
    const bool alone = gone == standing + step;
    for (int i = alone ? standing : gone; i != end; i += step) grid.measured.col(i).setConstant(missing);
  };
  mask(first - 1, -1, -1);
  mask(last + 1, n, 1);
}

/// Of the moving part, and faster than what a wheel does once a turn and by an uneven rim.
void set_tones(RunGrid& grid, const run_log::RunLog& log) {
  constexpr double fewest_cycles = 8.0;  // in the run
  constexpr double orders = 8.5;         // of the wheel's turn
  int first = -1, last = -1;
  for (int i = 0; i < grid.bins(); ++i) {
    if (!grid.moving[static_cast<std::size_t>(i)]) continue;
    if (first < 0) first = i;
    last = i;
  }
  if (last <= first) return;
  const double start = first_stamp(log), span = (last - first) * grid.bin;
  grid.tones = tones_of(log, start + grid.time(first), start + grid.time(last),
                        std::max(fewest_cycles / span, orders * largest_wheel_rate(grid) / (2.0 * M_PI)));
}

void take_averages(RunGrid& grid) {
  if (!grid.declared.averages) return;
  const logs::Averages& a = *grid.declared.averages;
  for (const Channel channel : all_channels)
    if (const auto& average = window_average(a, channel); average && !grid.has(channel))
      grid.windows.push_back({channel, a.window_start, a.window_end, average->mean});
}

}  // namespace

const std::optional<logs::Average>& window_average(const logs::Averages& averages, Channel channel) {
  switch (channel) {
    case Channel::drawbar_pull:
      return averages.drawbar_pull;
    case Channel::side_force:
      return averages.side_force;
    case Channel::normal_load:
      return averages.normal_load;
    case Channel::hub_displacement:
      return averages.hub_displacement;
    case Channel::pitch_torque:
      return averages.pitch_torque;
    case Channel::motor_effort:
      break;
  }
  return averages.motor_effort;
}

double first_stamp(const run_log::RunLog& log) {
  double first = std::numeric_limits<double>::infinity();
  for (const auto* times : {&log.ft.time, &log.draw_wire.time, &log.joints.time})
    if (!times->empty()) first = std::min(first, times->front());
  return first;
}

void set_slip(RunGrid& grid, double radius) {
  grid.slip.resize(grid.bins());
  for (int i = 0; i < grid.bins(); ++i) {
    const auto& m = grid.motion[static_cast<std::size_t>(i)];
    grid.slip[i] = rig::slip_ratio(m.carriage_velocity, radius * m.wheel_rate);
  }
}

double typical_slip(const RunGrid& run) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < run.bins(); ++i)
    if (run.moving[static_cast<std::size_t>(i)]) {
      sum += run.slip[i];
      ++count;
    }
  return count > 0 ? sum / count : run.declared.slip;
}

double typical_carriage_speed(const RunGrid& run) {
  double sum = 0.0, count = 0.0;
  for (int i = 0; i < run.bins(); ++i)
    if (run.moving[static_cast<std::size_t>(i)]) {
      sum += run.motion[static_cast<std::size_t>(i)].carriage_velocity;
      count += 1.0;
    }
  return count > 0.0 ? sum / count : 0.0;
}

double largest_wheel_rate(const RunGrid& run) {
  double rate = 0.0;
  for (int i = 0; i < run.bins(); ++i)
    if (run.moving[static_cast<std::size_t>(i)])
      rate = std::max(rate, std::abs(run.motion[static_cast<std::size_t>(i)].wheel_rate));
  return rate;
}

bool RunGrid::has(Channel channel) const {
  return (measured.row(index_of(channel)).array() == measured.row(index_of(channel)).array()).any();
}

RunGrid grid_of(const logs::Run& declared, const std::string& name, const run_log::RunLog& log, double radius,
                const GridOptions& options) {
  if (log.joints.time.size() < 2)
    throw Error(fmt::format("{}: no joint states, nothing drives the twin", name));
  RunGrid grid;
  grid.name = name;
  grid.declared = declared;
  grid.bin = options.bin;
  grid.radius = radius;
  const double start = first_stamp(log);
  const double end = log.joints.time.back();
  const int n = static_cast<int>((end - start) / options.bin);
  if (n < 5) throw Error(fmt::format("{}: lasts {:.2f} s, too short to compare", name, end - start));

  const auto binned = [&](const std::vector<double>& times, const auto& value) {
    Binning binning(start, options.bin, n);
    for (std::size_t i = 0; i < times.size(); ++i) binning.add(times[i], value(i));
    return binning.means();
  };
  grid.measured.setConstant(channel_rows, n, missing);
  const auto set = [&](Channel channel, const Eigen::VectorXd& values) {
    grid.measured.row(index_of(channel)) = values.transpose();
  };
  const run_log::WrenchSeries& ft = log.ft;
  set(Channel::drawbar_pull, binned(ft.time, [&](std::size_t i) { return ft.force[i].x(); }));
  set(Channel::side_force, binned(ft.time, [&](std::size_t i) { return ft.force[i].y(); }));
  set(Channel::normal_load, binned(ft.time, [&](std::size_t i) { return ft.force[i].z(); }));
  set(Channel::pitch_torque, binned(ft.time, [&](std::size_t i) { return ft.torque[i].y(); }));
  set(Channel::hub_displacement,
      binned(log.draw_wire.time, [&](std::size_t i) { return log.draw_wire.value[i]; }));
  if (!log.joints.wheel_effort.empty())
    set(Channel::motor_effort,
        binned(log.joints.time, [&](std::size_t i) { return log.joints.wheel_effort[i]; }));

  rig::RunConditions conditions;
  conditions.load = declared.load;
  conditions.steering_angle = declared.steering_angle;
  conditions.slip = declared.slip;
  conditions.wheel_speed = declared.wheel_speed;
  const rig::MotionSeries motion = rig::motion_of_log(log, conditions, options.bin);
  const auto column = [&](double rig::MeasuredMotion::*member) {
    Binning binning(start, options.bin, n);
    for (const auto& m : motion) binning.add(m.time, m.*member);
    return binning.means();
  };
  const Eigen::VectorXd position = column(&rig::MeasuredMotion::carriage_position);
  const Eigen::VectorXd velocity = column(&rig::MeasuredMotion::carriage_velocity);
  const Eigen::VectorXd angle = column(&rig::MeasuredMotion::wheel_angle);
  const Eigen::VectorXd rate = column(&rig::MeasuredMotion::wheel_rate);
  const Eigen::VectorXd temperature = column(&rig::MeasuredMotion::temperature);
  grid.motion.resize(static_cast<std::size_t>(n));
  rig::MeasuredMotion last = motion.front();
  for (int i = 0; i < n; ++i) {
    rig::MeasuredMotion& m = grid.motion[static_cast<std::size_t>(i)];
    m = last;
    if (std::isfinite(position[i])) {
      m.carriage_position = position[i];
      m.carriage_velocity = velocity[i];
      m.wheel_angle = angle[i];
      m.wheel_rate = rate[i];
      m.temperature = temperature[i];
    } else {
      grid.measured.col(i).setConstant(missing);
    }
    m.time = (i + 0.5) * options.bin;
    last = m;
  }
  set_slip(grid, radius);
  mask_changes_of_speed(grid, radius);
  mask_settling(grid);
  take_averages(grid);
  grid.touch = first_touch(log);
  grid.lag = draw_wire_lag(log);
  grid.lag_curves = lag_curves(log);
  set_tones(grid, log);
  return grid;
}

RunGrid grid_of_averages(const logs::Run& declared, const std::string& name, double radius,
                         const GridOptions& options) {
  if (!declared.averages) throw Error(fmt::format("{}: neither a bag nor averages", name));
  RunGrid grid;
  grid.name = name;
  grid.declared = declared;
  grid.bin = options.bin;
  grid.radius = radius;
  const int n = std::max(5, static_cast<int>(std::ceil(declared.averages->window_end / options.bin)));
  const rig::Speeds speeds = rig::speeds_of_slip(declared.slip, declared.wheel_speed, radius);
  grid.measured.setConstant(channel_rows, n, missing);
  grid.motion.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    rig::MeasuredMotion& m = grid.motion[static_cast<std::size_t>(i)];
    m.time = (i + 0.5) * options.bin;
    m.carriage_velocity = speeds.carriage;
    m.wheel_rate = speeds.wheel;
    m.carriage_position = speeds.carriage * m.time;
    m.wheel_angle = speeds.wheel * m.time;
    m.load = declared.load;
    m.steering_angle = declared.steering_angle;
  }
  grid.moving.assign(static_cast<std::size_t>(n), true);
  set_slip(grid, radius);
  take_averages(grid);
  return grid;
}

RunGrid condensed(const RunGrid& grid, int bins) {
  RunGrid result;
  result.name = grid.name;
  result.declared = grid.declared;
  result.radius = grid.radius;
  std::vector<int> moving;
  for (int i = 0; i < grid.bins(); ++i)
    if (grid.moving[static_cast<std::size_t>(i)]) moving.push_back(i);
  const int n = std::min(bins, static_cast<int>(moving.size()));
  if (n == 0) throw Error(fmt::format("{}: neither wheel nor carriage moves", grid.name));
  result.bin = grid.bin * static_cast<double>(moving.size()) / n;
  result.measured.setConstant(channel_rows, n, missing);
  result.slip.setZero(n);
  result.moving.assign(static_cast<std::size_t>(n), true);
  for (int k = 0; k < n; ++k) {
    const std::size_t begin = moving.size() * static_cast<std::size_t>(k) / static_cast<std::size_t>(n);
    const std::size_t end = moving.size() * static_cast<std::size_t>(k + 1) / static_cast<std::size_t>(n);
    const double count = static_cast<double>(end - begin);
    rig::MeasuredMotion mean = grid.motion[static_cast<std::size_t>(moving[begin])];
    mean.carriage_position = mean.carriage_velocity = mean.wheel_angle = mean.wheel_rate = mean.temperature =
        0.0;
    Eigen::Matrix<double, channel_rows, 1> sum = Eigen::Matrix<double, channel_count, 1>::Zero(), seen = sum;
    for (std::size_t j = begin; j < end; ++j) {
      const auto& m = grid.motion[static_cast<std::size_t>(moving[j])];
      mean.carriage_position += m.carriage_position / count;
      mean.carriage_velocity += m.carriage_velocity / count;
      mean.wheel_angle += m.wheel_angle / count;
      mean.wheel_rate += m.wheel_rate / count;
      mean.temperature += m.temperature / count;
      result.slip[k] += grid.slip[moving[j]] / count;
      for (int c = 0; c < channel_rows; ++c)
        if (std::isfinite(grid.measured(c, moving[j]))) {
          sum[c] += grid.measured(c, moving[j]);
          seen[c] += 1.0;
        }
    }
    mean.time = grid.motion[static_cast<std::size_t>(moving.front())].time + (k + 0.5) * result.bin;
    result.motion.push_back(mean);
    for (int c = 0; c < channel_rows; ++c)
      if (k > 0 && seen[c] > 0.5 * count) result.measured(c, k) = sum[c] / seen[c];
  }
  return result;
}

std::vector<RunGrid> read_runs(const logs::Experiment& experiment, const GridOptions& options) {
  std::vector<std::optional<run_log::RunLog>> logs;
  double longest = 0.0;
  for (const logs::Run& run : experiment.runs) {
    logs.emplace_back();
    if (run.bag) {
      logs.back() = logs::read_run_log(experiment.path_of(*run.bag));
      if (!logs.back()->joints.time.empty())
        longest = std::max(longest, logs.back()->joints.time.back() - first_stamp(*logs.back()));
    } else if (run.averages) {
      longest = std::max(longest, run.averages->window_end);
    }
  }
  GridOptions common = options;
  common.bin = std::max(options.bin, longest / options.most_bins);
  std::vector<RunGrid> grids;
  for (std::size_t i = 0; i < experiment.runs.size(); ++i) {
    const logs::Run& run = experiment.runs[i];
    grids.push_back(logs[i]
                        ? grid_of(run, *run.bag, *logs[i], experiment.wheel.radius, common)
                        : grid_of_averages(run, fmt::format("run_{}", i), experiment.wheel.radius, common));
  }
  return grids;
}

}  // namespace wheel_twin::twin
