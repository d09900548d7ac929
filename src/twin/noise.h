// What a perfect twin would still show: noise of the gridded channels, estimated from data. While the wheel
// moves, a first-order autoregressive process (granular fluctuation), an offset of each run (packing, what
// the baseline misses) and what the twin misses of how a wheel leaves its print; at rest, sensor noise about
// an offset of each run. Whitening is linear, so that least squares on whitened residuals is maximum
// likelihood for that model.
#pragma once

#include <array>
#include <vector>

#include "twin/run_grid.h"
#include "twin/simulate.h"

namespace wheel_twin::twin {

/// What a run shows on top as its wheel leaves its print. It dies away as exp(-x/length) over the travel x of
/// rim or carriage, the longer of both.
struct Start {
  double deviation = 0.0;
  double length = 0.1;  ///< m
};

struct ChannelNoise {
  double deviation = 0.0;   ///< of a bin while moving, about the run's offset
  double keep = 0.0;        ///< correlation of neighbouring bins
  double run_offset = 0.0;  ///< deviation of the offset of a run while moving
  Start start;
  double rest = 0.0;         ///< deviation of a bin at rest
  double rest_offset = 0.0;  ///< deviation of the offset of a run at rest
};

using NoiseModel = std::array<ChannelNoise, channel_count>;

/// Smallest noise that is credible for a channel: resolution and noise of the declared sensors over a bin,
/// and what a contact law misses at best.
using NoiseFloor = std::array<double, channel_count>;
NoiseFloor noise_floor(const logs::Experiment& experiment, double bin);

/// A stretch of bins in which a run either moves or rests throughout.
struct Segment {
  int begin = 0;
  int end = 0;
  bool moving = false;
};
std::vector<Segment> segments_of(const RunGrid& grid);

/// Deviation and correlation about a slowly varying level (a running mean of `window` bins is removed, its
/// loss of variance made up for), so that an effect with a slow course does not count as noise.
NoiseModel estimate_noise(const std::vector<const RunGrid*>& grids, const std::vector<Residual>& residuals,
                          const NoiseFloor& floor);

/// Deviation of the runs' levels at rest about their median, by channel: how differently wheels stand. Zero
/// with less than three.
std::array<double, channel_count> scatter_at_rest(const std::vector<const RunGrid*>& grids,
                                                  const std::vector<Residual>& residuals);

/// What runs show beyond `noise` as they start, by channel: the likeliest of a few lengths.
std::array<Start, channel_count> starts_of(const NoiseModel& noise, const std::vector<const RunGrid*>& grids,
                                           const std::vector<Residual>& residuals);

/// Weight of each of `grids` (sum 1) as a witness for `run`: those nearest in slip and load count.
std::vector<double> nearness(const std::vector<const RunGrid*>& grids, const RunGrid& run);

/// Noise of each of `runs`: `pooled`, with the deviation that each channel has on those of `grids` nearest in
/// slip and load. A wheel that digs shakes the forces more than one that rolls.
std::vector<NoiseModel> noise_by_run(const NoiseModel& pooled, const std::vector<const RunGrid*>& grids,
                                     const std::vector<Residual>& residuals, const NoiseFloor& floor,
                                     const std::vector<const RunGrid*>& runs);

/// Appends the whitened residual of one run, channel by channel and segment by segment, to `out`; unit
/// variance when `residual` is noise. The count appended depends on the grid alone. `block` receives for each
/// value the index of its stretch of about `block_length` seconds, counted from `first_block`; returns the
/// next free index.
int whiten(const RunGrid& grid, const Residual& residual, const NoiseModel& noise, std::vector<double>& out,
           std::vector<int>* block = nullptr, int first_block = 0, double block_length = 6.0);

/// Running mean over about 30 values: the slow course.
std::vector<double> running_mean(const std::vector<double>& values);

/// Values less their straight line and their running mean (about 30 bins), scaled so that white noise keeps
/// its variance.
std::vector<double> without_level(const std::vector<double>& course);

/// Standard deviation that a few outliers (a jump, a rock) do not move: 1.4826 times the median magnitude.
double robust_deviation(const std::vector<double>& values);

}  // namespace wheel_twin::twin
