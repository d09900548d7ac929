// One run on a common time grid: every channel averaged over equal bins (the low-pass that measured and twin
// share) and the measured motion that drives the twin. Bins in which the speeds change are masked: what a
// sensor's filter and clock do there says nothing about soil or wheel.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "rig/replay.h"
#include "run_log/run_log.h"
#include "twin/channel.h"
#include "twin/first_touch.h"
#include "twin/lag.h"
#include "twin/tones.h"

namespace wheel_twin::twin {

/// Rows of a matrix of channels by bins, in the order of all_channels.
inline constexpr int channel_rows = static_cast<int>(channel_count);

/// A channel of which only the mean over a window is known.
struct WindowMean {
  Channel channel = Channel::drawbar_pull;
  double start = 0.0;  ///< s from the start of the run
  double end = 0.0;
  double mean = 0.0;
};

/// The average of a channel among those of a window.
const std::optional<logs::Average>& window_average(const logs::Averages& averages, Channel channel);

struct RunGrid {
  std::string name;  ///< the bag's file name, or `run_<index>` without one
  logs::Run declared;
  double bin = 0.2;          ///< s
  double radius = 0.0;       ///< of the wheel, m
  rig::MotionSeries motion;  ///< at the bin centres, time from the start of the run
  Eigen::Matrix<double, channel_rows, Eigen::Dynamic> measured;  ///< NaN: not measured or masked
  Eigen::VectorXd slip;                                          ///< of the measured speeds, by bin
  std::vector<bool> moving;  ///< wheel or carriage moves throughout the bin
  std::vector<WindowMean> windows;
  std::optional<FirstTouch> touch;
  std::optional<Lag> lag;               ///< of the draw wire behind the wrench
  std::optional<LagCurves> lag_curves;  ///< of the same
  Tones tones;                          ///< while it moves

  int bins() const { return static_cast<int>(motion.size()); }
  double time(int i) const { return motion[static_cast<std::size_t>(i)].time; }
  bool has(Channel channel) const;  ///< at least one bin of it is measured
};

/// Mean slip while it moves, of the measured speeds; the declared one when it does not.
double typical_slip(const RunGrid& run);

/// Mean speed of the carriage while the run moves, m/s.
double typical_carriage_speed(const RunGrid& run);

/// Largest magnitude of the wheel's rate while it moves, rad/s.
double largest_wheel_rate(const RunGrid& run);

/// The first stamp of a log, which is the start of its run, s.
double first_stamp(const run_log::RunLog& log);

struct GridOptions {
  double bin = 0.2;  ///< s
  /// Of the longest run, for which all bins of an experiment are made longer (read_runs).
  double most_bins = std::numeric_limits<double>::infinity();
};

/// `log` must have joint states. `radius` of the wheel turns rates into rim speeds, m.
RunGrid grid_of(const logs::Run& declared, const std::string& name, const run_log::RunLog& log, double radius,
                const GridOptions& options = {});

/// A run without a bag: constant declared speeds up to the end of its window, window means only.
RunGrid grid_of_averages(const logs::Run& declared, const std::string& name, double radius,
                         const GridOptions& options = {});

/// The moving part of a run on `bins` equally long bins (fewer when it is shorter): enough for a steady
/// state, and as much faster to simulate. The first bin, from which a simulation starts at rest, and the
/// windows stay out.
RunGrid condensed(const RunGrid& grid, int bins);

/// Slip of every bin by the speeds of the motion. `radius` of the wheel, m.
void set_slip(RunGrid& grid, double radius);

/// All runs of an experiment, in its order, on bins of one length. Throws Error naming the run that cannot be
/// read.
std::vector<RunGrid> read_runs(const logs::Experiment& experiment, const GridOptions& options = {});

}  // namespace wheel_twin::twin
