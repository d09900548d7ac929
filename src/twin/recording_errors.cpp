#include "twin/recording_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/error.h"
#include "logs/statistics.h"
#include "rig/speeds.h"
#include "twin/simulate.h"

namespace wheel_twin::twin {
namespace {

struct Unit {
  double factor;     // of what was logged over what it should be
  const char* what;  // "the wheel's rate is {}"
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double explained = 0.35;      // of the square of a channel: the declared twin is a first guess
constexpr double much_better = 6.0;     // misfit as logged over misfit put right
constexpr double speed_accuracy = 0.2;  // of the declared speeds, in log
constexpr double largest_slip_error = 0.25;
constexpr double least_load_share = 0.4, largest_load_share = 2.5;  // of the declared load

std::vector<std::string> names_of(const std::vector<RunGrid*>& runs) {
  std::vector<std::string> names;
  for (const RunGrid* run : runs) names.push_back(run->name);
  return names;
}

/// Mean rate of change of a series, or mean of it, while the run moves.
std::optional<double> mean_while_moving(const RunGrid& run, double rig::MeasuredMotion::*member, bool rate) {
  double sum = 0.0, time = 0.0;
  for (int i = 1; i < run.bins(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!run.moving[k] || !run.moving[k - 1]) continue;
    sum += rate ? run.motion[k].*member - run.motion[k - 1].*member : run.bin * run.motion[k].*member;
    time += run.bin;
  }
  if (time == 0.0) return std::nullopt;
  return sum / time;
}

struct JointSeries {
  const char* name;
  double rig::MeasuredMotion::*member;
  bool is_position;
  bool of_wheel;
};

constexpr std::array<JointSeries, 4> joint_series = {
    {{"the wheel's rate", &rig::MeasuredMotion::wheel_rate, false, true},
     {"the wheel's angle", &rig::MeasuredMotion::wheel_angle, true, true},
     {"the carriage's speed", &rig::MeasuredMotion::carriage_velocity, false, false},
     {"the carriage's position", &rig::MeasuredMotion::carriage_position, true, false}}};

/// Units and signs of the joint states against the declared speeds.
void put_motion_right(const std::vector<RunGrid*>& runs, double radius, std::vector<RecordingError>& found) {
  static const std::vector<Unit> angular = {{57.29578, "logged in degrees, not rad"},
                                            {-57.29578, "logged in degrees and flipped"},
                                            {9.549297, "logged in revolutions a minute"},
                                            {0.1591549, "logged in revolutions"},
                                            {-1.0, "flipped"}};
  static const std::vector<Unit> linear = {{1000.0, "logged in millimetres, not metres"},
                                           {-1000.0, "logged in millimetres and flipped"},
                                           {100.0, "logged in centimetres, not metres"},
                                           {0.001, "logged in kilometres, not metres"},
                                           {-1.0, "flipped"}};
  bool changed = false;
  for (const JointSeries& series : joint_series) {
    std::vector<double> ratios;
    for (const RunGrid* run : runs) {
      const rig::Speeds speeds = rig::speeds_of_slip(run->declared.slip, run->declared.wheel_speed, radius);
      const double declared = series.of_wheel ? speeds.wheel : speeds.carriage;
      const auto logged = mean_while_moving(*run, series.member, series.is_position);
      if (logged && std::abs(declared) > 1e-4) ratios.push_back(*logged / declared);
    }
    if (ratios.empty()) continue;
    const double ratio = logs::median(ratios);
    for (const Unit& unit : series.of_wheel ? angular : linear) {
      if (!(ratio / unit.factor > 0.0) || std::abs(std::log(ratio / unit.factor)) > speed_accuracy) continue;
      for (RunGrid* run : runs)
        for (rig::MeasuredMotion& m : run->motion) m.*series.member /= unit.factor;
      found.push_back({fmt::format("{} is {}", series.name, unit.what), names_of(runs)});
      changed = true;
      break;
    }
  }
  if (changed)
    for (RunGrid* run : runs) set_slip(*run, radius);
}

/// Levels of a channel, at rest and moving, of every run: measured and as the declared twin has them.
struct Levels {
  std::vector<double> measured, twin;

  double misfit(double factor, double least) const {
    double left = 0.0, all = 0.0;
    for (std::size_t i = 0; i < twin.size(); ++i) {
      left += std::pow(measured[i] / factor - twin[i], 2);
      all += twin[i] * twin[i] + least * least;
    }
    return all > 0.0 ? left / all : 0.0;
  }

  /// Correlation about the means; nothing where the twin's levels hardly differ.
  std::optional<double> correlation() const {
    double m = 0.0, t = 0.0, mm = 0.0, tt = 0.0, mt = 0.0;
    const auto n = static_cast<double>(twin.size());
    for (std::size_t i = 0; i < twin.size(); ++i) m += measured[i] / n, t += twin[i] / n;
    for (std::size_t i = 0; i < twin.size(); ++i) {
      mm += std::pow(measured[i] - m, 2);
      tt += std::pow(twin[i] - t, 2);
      mt += (measured[i] - m) * (twin[i] - t);
    }
    if (tt < 0.01 * n * t * t || mm <= 0.0 || tt <= 0.0) return std::nullopt;
    return mt / std::sqrt(mm * tt);
  }
};

using AllLevels = std::array<Levels, channel_count>;

AllLevels levels_of(const std::vector<RunGrid*>& runs, const TwinConfig& declared) {
  AllLevels levels;
  for (const RunGrid* run : runs) {
    const Predicted predicted = simulate(declared, *run);
    for (std::size_t c = 0; c < channel_count; ++c)
      for (const bool moving : {false, true}) {
        double measured = 0.0, twin = 0.0;
        int count = 0;
        for (int i = 0; i < run->bins(); ++i) {
          const double value = run->measured(static_cast<Eigen::Index>(c), i);
          if (run->moving[static_cast<std::size_t>(i)] != moving || !std::isfinite(value)) continue;
          measured += value;
          twin += predicted(static_cast<Eigen::Index>(c), i);
          ++count;
        }
        if (count < 3) continue;
        levels[c].measured.push_back(measured / count);
        levels[c].twin.push_back(twin / count);
      }
  }
  return levels;
}

void divide(const std::vector<RunGrid*>& runs, Channel channel, double factor) {
  for (RunGrid* run : runs) {
    run->measured.row(index_of(channel)) /= factor;
    for (WindowMean& window : run->windows)
      if (window.channel == channel) window.mean /= factor;
  }
}

/// The unit under which a channel agrees with the declared twin, where it does not as it was logged.
std::optional<Unit> unit_of_levels(const Levels& levels, const std::vector<Unit>& units, double least) {
  if (levels.twin.empty()) return std::nullopt;
  std::optional<Unit> best;
  double lowest = levels.misfit(1.0, least) / much_better;
  for (const Unit& unit : units) {
    const double misfit = levels.misfit(unit.factor, least);
    const std::optional<double> correlation = levels.correlation();
    const bool same_course = !correlation || *correlation * unit.factor > 0.5 * std::abs(unit.factor);
    if (misfit > explained || misfit > lowest || !same_course) continue;
    best = unit;
    lowest = misfit;
  }
  return best;
}

/// Which axis of the log, with which sign, is which axis of the force.
struct Axes {
  std::array<int, 3> from = {0, 1, 2};
  std::array<double, 3> sign = {1.0, 1.0, 1.0};
  double misfit = 0.0;
  int changes = 0;
};

std::optional<Axes> best_axes(const AllLevels& levels, double load) {
  for (int c = 0; c < 3; ++c)
    if (levels[static_cast<std::size_t>(c)].twin.empty() ||
        levels[static_cast<std::size_t>(c)].twin.size() != levels[0].twin.size())
      return std::nullopt;
  const double least = 0.05 * load;
  const auto misfit_of = [&](Axes& axes) {
    axes.misfit = 0.0;
    axes.changes = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto from = static_cast<std::size_t>(axes.from[c]);
      const Levels mixed{levels[from].measured, levels[c].twin};
      axes.misfit += std::min(4.0, mixed.misfit(axes.sign[c], least)) / 3.0;
      axes.changes += (from != c) + (axes.sign[c] < 0.0);
    }
  };
  Axes as_logged;
  misfit_of(as_logged);
  std::optional<Axes> best;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (unsigned signs = 0; signs < 8; ++signs) {
      Axes axes;
      axes.from = order;
      for (std::size_t c = 0; c < 3; ++c) axes.sign[c] = ((signs >> c) & 1U) != 0U ? -1.0 : 1.0;
      misfit_of(axes);
      bool sensible = true;  // a sign is told only by a force that is there and follows the twin
      for (std::size_t c = 0; c < 3; ++c) {
        const Levels mixed{levels[static_cast<std::size_t>(axes.from[c])].measured, levels[c].twin};
        double square = 0.0;
        for (const double t : levels[c].twin) square += t * t / static_cast<double>(levels[c].twin.size());
        const std::optional<double> correlation = mixed.correlation();
        if (axes.sign[c] < 0.0 && (square < least * least || (correlation && *correlation > -0.5)))
          sensible = false;
        if (mixed.misfit(axes.sign[c], least) > explained) sensible = false;
      }
      if (!sensible || axes.misfit * much_better > as_logged.misfit) continue;
      if (!best || axes.changes < best->changes ||
          (axes.changes == best->changes && axes.misfit < best->misfit))
        best = axes;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

void put_axes_right(const std::vector<RunGrid*>& runs, const Axes& axes, std::vector<RecordingError>& found) {
  constexpr const char* names = "xyz";
  for (RunGrid* run : runs) {
    const auto logged = run->measured.topRows(3).eval();
    for (int c = 0; c < 3; ++c)
      run->measured.row(c) =
          axes.sign[static_cast<std::size_t>(c)] * logged.row(axes.from[static_cast<std::size_t>(c)]);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const auto from = static_cast<std::size_t>(axes.from[c]);
    if (from == c && axes.sign[c] < 0.0)
      found.push_back({fmt::format("the {} axis of the force is flipped", names[c]), names_of(runs)});
    if (from != c)
      found.push_back({fmt::format("what is logged as the {} axis of the force is {}its {} axis", names[from],
                                   axes.sign[c] < 0.0 ? "the negative of " : "", names[c]),
                       names_of(runs)});
  }
}

void put_channels_right(const std::vector<RunGrid*>& runs, const TwinConfig& declared,
                        std::vector<RecordingError>& found) {
  static const std::vector<Unit> force = {{0.001, "in kilonewtons, not newtons"},
                                          {1000.0, "in millinewtons, not newtons"},
                                          {0.1019716, "in kilograms-force, not newtons"},
                                          {0.2248089, "in pounds-force, not newtons"}};
  static const std::vector<Unit> displacement = {
      {1000.0, "in millimetres, not metres"}, {-1000.0, "in millimetres and flipped"},
      {100.0, "in centimetres, not metres"},  {39.37008, "in inches, not metres"},
      {0.001, "in kilometres, not metres"},   {-1.0, "flipped: positive upwards"}};
  static const std::vector<Unit> effort = {{-1.0, "flipped"},
                                           {1000.0, "in newton millimetres, not newton metres"},
                                           {100.0, "in newton centimetres"}};
  double load = 1.0;
  for (const RunGrid* run : runs) load = std::max(load, run->declared.load);
  const AllLevels levels = levels_of(runs, declared);
  const auto put = [&](Channel channel, const char* name, const std::vector<Unit>& units, double least) {
    const auto unit = unit_of_levels(levels[index_of(channel)], units, least);
    if (!unit) return 1.0;
    divide(runs, channel, unit->factor);
    found.push_back({fmt::format("{} is logged {}", name, unit->what), names_of(runs)});
    return unit->factor;
  };
  // The dead weight tells the unit of the force, which all axes share.
  const double factor = put(Channel::normal_load, "the force", force, 0.0);
  if (factor != 1.0) {
    divide(runs, Channel::drawbar_pull, factor);
    divide(runs, Channel::side_force, factor);
  }
  AllLevels forces = levels;
  for (std::size_t c = 0; c < 3; ++c)
    for (double& m : forces[c].measured) m /= factor;
  if (const auto axes = best_axes(forces, load)) put_axes_right(runs, *axes, found);
  put(Channel::hub_displacement, "the hub displacement", displacement, 2e-4);
  put(Channel::motor_effort, "the motor effort", effort, 0.02);
  // The sensor's place is not known before calibration: only a torque no arm of a metre could make is told.
  const Levels& torque = levels[index_of(Channel::pitch_torque)];
  double largest = 0.0;
  for (const double m : torque.measured) largest = std::max(largest, std::abs(m));
  if (largest > 3.0 * load) {
    divide(runs, Channel::pitch_torque, 1000.0);
    found.push_back({"the torque is logged in newton millimetres, not newton metres", names_of(runs)});
  }
}

/// The value that a channel holds in every run while it moves, and across runs: no rig does that, a
/// saturated or unconnected sensor does.
std::optional<double> standing_value(const std::vector<RunGrid*>& runs, Channel channel) {
  constexpr double nearly_always = 0.9;
  std::map<double, int> seen;
  int count = 0, most = 0;
  double value = 0.0;
  for (const RunGrid* run : runs)
    for (int i = 0; i < run->bins(); ++i) {
      const double v = run->measured(index_of(channel), i);
      if (!run->moving[static_cast<std::size_t>(i)] || !std::isfinite(v)) continue;
      ++count;
      if (++seen[v] > most) most = seen[v], value = v;
    }
  if (count < 12 || most < nearly_always * count) return std::nullopt;
  return value;
}

/// Takes out channels that stand still. A side force of zero does so of right, and so does a normal load
/// without noise.
void leave_out_what_stands_still(const std::vector<RunGrid*>& runs, std::vector<RecordingError>& found) {
  bool anything = false, all = true;
  for (const Channel channel :
       {Channel::drawbar_pull, Channel::hub_displacement, Channel::pitch_torque, Channel::motor_effort}) {
    if (std::none_of(runs.begin(), runs.end(), [&](const RunGrid* run) { return run->has(channel); }))
      continue;
    const std::optional<double> value = standing_value(runs, channel);
    all = all && value;
    if (!value) continue;
    anything = true;
    for (RunGrid* run : runs) run->measured.row(index_of(channel)).setConstant(nan);
    found.push_back({fmt::format("{} stands at {:.4g} {} (saturated, or not connected)", name_of(channel),
                                 shown_factor(channel) * *value, shown_unit_of(channel)),
                     names_of(runs)});
  }
  if (anything && all)
    throw Error(fmt::format("{}: every channel stands still while the wheel moves: {}", runs.front()->name,
                            found.back().what));
}

/// Takes out what a sensor cut off at the end of its range: runs of different slip stand together at the
/// largest value (with `sign` -1: the smallest) of all, as nothing that fluctuates does; or, further apart in
/// slip than any soil pulls alike, within a sensor's noise of `noise`.
bool leave_out_what_is_cut_off(const std::vector<RunGrid*>& runs, Channel channel, double sign, double noise,
                               std::vector<RecordingError>& found) {
  constexpr double share = 0.01;   // of the range of values
  constexpr double scatter = 5.0;  // from the lowest to the highest of noise, in deviations
  constexpr double mostly = 0.6;   // of the bins of a run
  const double other_slip = noise > 0.0 ? 0.35 : 0.05;
  double most = -std::numeric_limits<double>::infinity(), least = -most;
  const auto for_moving = [&](const RunGrid& run, const auto& act) {
    for (int i = 0; i < run.bins(); ++i) {
      const double value = sign * run.measured(index_of(channel), i);
      if (run.moving[static_cast<std::size_t>(i)] && std::isfinite(value)) act(i, value);
    }
  };
  for (const RunGrid* run : runs)
    for_moving(*run,
               [&](int, double value) { most = std::max(most, value), least = std::min(least, value); });
  const double edge = most - std::max(share * (most - least), scatter * noise);
  std::vector<RunGrid*> cut;
  double lowest_slip = 1.0, highest_slip = -1.0;
  for (RunGrid* run : runs) {
    int all = 0, at_edge = 0;
    for_moving(*run, [&](int, double value) { ++all, at_edge += value >= edge ? 1 : 0; });
    if (all < 12 || at_edge < mostly * all) continue;
    cut.push_back(run);
    lowest_slip = std::min(lowest_slip, typical_slip(*run));
    highest_slip = std::max(highest_slip, typical_slip(*run));
  }
  if (cut.size() < 2 || highest_slip - lowest_slip < other_slip) return false;
  for (RunGrid* run : runs) {
    std::vector<int> bins;
    for_moving(*run, [&](int i, double value) {
      if (value >= edge) bins.push_back(i);
    });
    for (const int i : bins) run->measured(index_of(channel), i) = nan;
  }
  found.push_back({fmt::format("{} is cut off at {:.4g} {}", name_of(channel),
                               shown_factor(channel) * sign * most, shown_unit_of(channel)),
                   names_of(cut)});
  return true;
}

}  // namespace

std::vector<RecordingError> put_right(const std::vector<RunGrid*>& runs, const TwinConfig& declared) {
  std::vector<RecordingError> found;
  if (runs.empty()) return found;
  put_motion_right(runs, declared.wheel.radius, found);
  leave_out_what_stands_still(runs, found);
  bool cut = false;
  for (const Channel channel : all_channels)
    for (const double sign : {1.0, -1.0})
      cut = leave_out_what_is_cut_off(runs, channel, sign, 0.0, found) || cut;
  try {
    put_channels_right(runs, declared, found);
  } catch (const Error&) {
    // A declared soil that cannot carry the load tells nothing about channels.
  }
  // What is noise of a pull is known once it is one, and in newtons.
  constexpr double bin_noise = 0.001;  // of the load
  for (const double sign : {1.0, -1.0})
    if (!cut)
      cut = leave_out_what_is_cut_off(runs, Channel::drawbar_pull, sign,
                                      bin_noise * runs.front()->declared.load, found);
  return found;
}

std::string contradiction(const RunGrid& run) {
  const double slip = typical_slip(run);
  if (std::abs(slip - run.declared.slip) > largest_slip_error)
    return fmt::format("slip {:.2f} is declared, its speeds say {:.2f}", run.declared.slip, slip);
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < run.bins(); ++i) {
    const double v = run.measured(index_of(Channel::normal_load), i);
    if (run.moving[static_cast<std::size_t>(i)] && std::isfinite(v)) sum += v, ++count;
  }
  if (count == 0 || !(run.declared.load > 0.0)) return {};
  const double share = sum / count / run.declared.load;
  if (share < least_load_share || share > largest_load_share)
    return fmt::format("a load of {:.3g} N is declared, the sensor says {:.3g} N", run.declared.load,
                       sum / count);
  return {};
}

int steady_bins_of(const RunGrid& run) {
  return static_cast<int>(std::count(run.moving.begin(), run.moving.end(), true));
}

}  // namespace wheel_twin::twin
