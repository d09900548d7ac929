#include "twin/noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "logs/statistics.h"

namespace wheel_twin::twin {
namespace {

constexpr int level_window = 31;                      // bins of the running mean that counts as slow course
constexpr double slip_reach = 0.1, load_reach = 0.2;  // between runs that fluctuate alike: slip, ln load

/// Indices of a segment at which a channel is measured.
std::vector<int> measured_bins(const RunGrid& grid, int channel, const Segment& segment) {
  std::vector<int> bins;
  for (int i = segment.begin; i < segment.end; ++i)
    if (std::isfinite(grid.measured(channel, i))) bins.push_back(i);
  return bins;
}

/// What the running mean takes of the deviation of a correlated fluctuation, beyond what it takes of white
/// noise, for which without_level makes up.
double loss_by_level(double keep) {
  const double white = 1.0 / level_window;
  return std::sqrt((1.0 - white) / (1.0 - std::min(0.5, white * (1.0 + keep) / (1.0 - keep))));
}

}  // namespace

std::vector<double> running_mean(const std::vector<double>& values) {
  const int n = static_cast<int>(values.size());
  const int half = std::min(level_window, n) / 2;
  std::vector<double> cumulated(values.size() + 1, 0.0);
  std::partial_sum(values.begin(), values.end(), cumulated.begin() + 1);
  std::vector<double> result(values.size());
  for (int i = 0; i < n; ++i) {
    const auto a = static_cast<std::size_t>(std::max(0, i - half)),
               b = static_cast<std::size_t>(std::min(n, i + half + 1));
    result[static_cast<std::size_t>(i)] = (cumulated[b] - cumulated[a]) / static_cast<double>(b - a);
  }
  return result;
}

std::vector<double> without_level(const std::vector<double>& course) {
  // The windows at the ends lie to one side, where a straight line would be left.
  const std::vector<double> values = course.size() > 2 ? logs::without_line(course) : course;
  const int n = static_cast<int>(values.size());
  const int half = std::min(level_window, n) / 2;
  const std::vector<double> level = running_mean(values);
  std::vector<double> result(values.size());
  for (int i = 0; i < n; ++i) {
    const int count = std::min(n, i + half + 1) - std::max(0, i - half);
    const double share = 1.0 - 1.0 / count;
    const auto k = static_cast<std::size_t>(i);
    result[k] = share > 0.0 ? (values[k] - level[k]) / std::sqrt(share) : 0.0;
  }
  return result;
}

double robust_deviation(const std::vector<double>& values) {
  std::vector<double> magnitude;
  for (const double v : values) magnitude.push_back(std::abs(v));
  return values.empty() ? 0.0 : 1.4826 * logs::median(std::move(magnitude));
}

NoiseFloor noise_floor(const logs::Experiment& experiment, double bin) {
  const auto of = [&](const std::optional<logs::DeclaredSensor>& sensor, double fallback) {
    if (!sensor) return fallback;
    const double samples = std::max(1.0, sensor->rate * bin);
    return std::hypot(sensor->noise, sensor->resolution / std::sqrt(12.0)) / std::sqrt(samples);
  };
  double load = 1.0;
  for (const logs::Run& run : experiment.runs) load = std::max(load, run.load);
  // A contact law is not better than a thousandth of the load, whatever the sensors are.
  const double force = std::max(0.001 * load, of(experiment.ft, 0.02));
  const double displacement = std::max(2e-5, of(experiment.draw_wire, 2e-5));
  const double torque = 0.05 * force;
  return {force, force, force, displacement, torque, torque};
}

std::vector<Segment> segments_of(const RunGrid& grid) {
  std::vector<Segment> segments;
  for (int i = 0; i < grid.bins(); ++i) {
    const bool moving = grid.moving[static_cast<std::size_t>(i)];
    if (segments.empty() || segments.back().moving != moving) segments.push_back({i, i, moving});
    segments.back().end = i + 1;
  }
  return segments;
}

NoiseModel estimate_noise(const std::vector<const RunGrid*>& grids, const std::vector<Residual>& residuals,
                          const NoiseFloor& floor) {
  NoiseModel noise;
  for (int c = 0; c < channel_rows; ++c) {
    std::vector<double> fluctuation, rest, rest_means;
    double lagged = 0.0, squared = 0.0;
    for (std::size_t r = 0; r < grids.size(); ++r)
      for (const Segment& segment : segments_of(*grids[r])) {
        const std::vector<int> bins = measured_bins(*grids[r], c, segment);
        if (bins.size() < 3) continue;
        std::vector<double> values;
        for (const int i : bins) values.push_back(residuals[r].bins(c, i));
        if (segment.moving) {
          const std::vector<double> level_free = without_level(values);
          fluctuation.insert(fluctuation.end(), level_free.begin(), level_free.end());
          const double limit = 4.0 * robust_deviation(level_free);
          for (std::size_t i = 1; i < level_free.size(); ++i) {
            if (std::abs(level_free[i]) > limit || std::abs(level_free[i - 1]) > limit) continue;
            lagged += level_free[i] * level_free[i - 1];
            squared += level_free[i] * level_free[i];
          }
        } else {
          const double mean =
              std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
          for (const double v : values) rest.push_back(v - mean);
          rest_means.push_back(mean);
        }
      }
    const double least = floor[static_cast<std::size_t>(c)];
    ChannelNoise& channel = noise[static_cast<std::size_t>(c)];
    channel.keep = squared > 0.0 ? std::clamp(lagged / squared, 0.0, 0.9) : 0.0;
    channel.deviation = std::max(least, loss_by_level(channel.keep) * robust_deviation(fluctuation));
    channel.rest = std::max(least, robust_deviation(rest));
    channel.rest_offset =
        rest_means.size() >= 3 ? std::max(least, robust_deviation(rest_means)) : channel.deviation;
  }
  return noise;
}

std::array<double, channel_count> scatter_at_rest(const std::vector<const RunGrid*>& grids,
                                                  const std::vector<Residual>& residuals) {
  std::array<double, channel_count> scatter{};
  for (int c = 0; c < channel_rows; ++c) {
    std::vector<double> means;
    for (std::size_t r = 0; r < grids.size(); ++r)
      for (const Segment& segment : segments_of(*grids[r])) {
        const std::vector<int> bins = measured_bins(*grids[r], c, segment);
        if (segment.moving || bins.empty()) continue;
        double sum = 0.0;
        for (const int i : bins) sum += residuals[r].bins(c, i);
        means.push_back(sum / static_cast<double>(bins.size()));
      }
    if (means.size() < 3) continue;
    const double middle = logs::median(means);
    for (double& mean : means) mean -= middle;
    scatter[static_cast<std::size_t>(c)] = robust_deviation(means);
  }
  return scatter;
}

std::vector<double> nearness(const std::vector<const RunGrid*>& grids, const RunGrid& run) {
  const auto log_load = [](const RunGrid& grid) { return std::log(std::max(1e-3, grid.declared.load)); };
  std::vector<double> distance;
  for (const RunGrid* grid : grids)
    distance.push_back(0.5 * (std::pow((typical_slip(run) - typical_slip(*grid)) / slip_reach, 2) +
                              std::pow((log_load(run) - log_load(*grid)) / load_reach, 2)));
  const double nearest = distance.empty() ? 0.0 : *std::min_element(distance.begin(), distance.end());
  std::vector<double> weights;
  for (const double d : distance) weights.push_back(std::exp(nearest - d));
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

std::vector<NoiseModel> noise_by_run(const NoiseModel& pooled, const std::vector<const RunGrid*>& grids,
                                     const std::vector<Residual>& residuals, const NoiseFloor& floor,
                                     const std::vector<const RunGrid*>& runs) {
  std::vector<NoiseModel> result(runs.size(), pooled);
  for (int c = 0; c < channel_rows; ++c) {
    const auto k = static_cast<std::size_t>(c);
    std::vector<const RunGrid*> witnesses;
    std::vector<double> log_deviation;
    for (std::size_t g = 0; g < grids.size(); ++g) {
      std::vector<double> fluctuation;
      for (const Segment& segment : segments_of(*grids[g])) {
        if (!segment.moving) continue;
        std::vector<double> values;
        for (const int i : measured_bins(*grids[g], c, segment)) values.push_back(residuals[g].bins(c, i));
        const std::vector<double> level_free = without_level(values);
        fluctuation.insert(fluctuation.end(), level_free.begin(), level_free.end());
      }
      if (fluctuation.size() < 20) continue;
      witnesses.push_back(grids[g]);
      log_deviation.push_back(
          std::log(std::max(floor[k], loss_by_level(pooled[k].keep) * robust_deviation(fluctuation))));
    }
    if (witnesses.empty()) continue;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const std::vector<double> weights = nearness(witnesses, *runs[r]);
      result[r][k].deviation =
          std::exp(std::inner_product(weights.begin(), weights.end(), log_deviation.begin(), 0.0));
    }
  }
  return result;
}

namespace {

/// A segment of a channel whose noise is white and has unit variance, but for what dies away from its start.
struct Whitened {
  Eigen::VectorXd residual;
  Eigen::VectorXd start;  ///< of a start of size one; empty at rest
};

/// A vector whose covariance is 1 + d^2 u u^T made white, u being `direction`.
void take_common(const Eigen::VectorXd& direction, double deviation, Eigen::VectorXd& vector) {
  const double length = direction.squaredNorm();
  if (!(deviation > 0.0 && length > 0.0)) return;
  const double share = (1.0 - 1.0 / std::sqrt(1.0 + deviation * deviation * length)) / length;
  vector -= share * direction.dot(vector) * direction;
}

/// What is left of a start at each bin of a moving segment.
std::vector<double> start_left(const RunGrid& grid, const Segment& segment, double length) {
  std::vector<double> left;
  double travel = 0.0;
  for (int i = segment.begin; i < segment.end; ++i) {
    const auto& m = grid.motion[static_cast<std::size_t>(i)];
    const double way =
        grid.bin * std::max(std::abs(m.carriage_velocity), grid.radius * std::abs(m.wheel_rate));
    left.push_back(std::exp(-(travel + 0.5 * way) / length));
    travel += way;
  }
  return left;
}

Whitened whitened_segment(const RunGrid& grid, const Residual& residual, int row, const Segment& segment,
                          const std::vector<int>& bins, const ChannelNoise& channel) {
  const double keep = segment.moving ? channel.keep : 0.0;
  const double deviation = segment.moving ? channel.deviation : channel.rest;
  const double innovation = deviation * std::sqrt(1.0 - keep * keep);
  const auto n = static_cast<Eigen::Index>(bins.size());
  const auto white = [&](const auto& value) {
    Eigen::VectorXd result(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const int bin = bins[static_cast<std::size_t>(k)];
      const bool follows = k > 0 && bin == bins[static_cast<std::size_t>(k) - 1] + 1;
      result[k] = follows ? (value(bin) - keep * value(bin - 1)) / innovation : value(bin) / deviation;
    }
    return result;
  };
  const Eigen::VectorXd level = white([](int) { return 1.0; });
  const double offset = segment.moving ? channel.run_offset : channel.rest_offset;
  Whitened whitened{white([&](int bin) { return residual.bins(row, bin); }), {}};
  take_common(level, offset, whitened.residual);
  if (!segment.moving) return whitened;
  const std::vector<double> left = start_left(grid, segment, channel.start.length);
  whitened.start = white([&](int bin) { return left[static_cast<std::size_t>(bin - segment.begin)]; });
  take_common(level, offset, whitened.start);
  take_common(whitened.start, channel.start.deviation, whitened.residual);
  return whitened;
}

}  // namespace

std::array<Start, channel_count> starts_of(const NoiseModel& noise, const std::vector<const RunGrid*>& grids,
                                           const std::vector<Residual>& residuals) {
  constexpr double shortest = 0.25;  // radii; the longest is eight times that
  constexpr int lengths = 4;
  std::array<Start, channel_count> starts;
  for (int c = 0; c < channel_rows; ++c) {
    Start& best = starts[static_cast<std::size_t>(c)];
    double most = 0.0;
    for (int k = 0; k < lengths; ++k) {
      ChannelNoise channel = noise[static_cast<std::size_t>(c)];
      channel.start.length = shortest * (1 << k) * (grids.empty() ? 0.0 : grids.front()->radius);
      if (!(channel.start.length > 0.0)) continue;
      std::vector<double> found, information;
      double square = 0.0;
      for (std::size_t r = 0; r < grids.size(); ++r)
        for (const Segment& segment : segments_of(*grids[r])) {
          const std::vector<int> bins = measured_bins(*grids[r], c, segment);
          if (bins.empty() || !segment.moving) continue;
          const Whitened w = whitened_segment(*grids[r], residuals[r], c, segment, bins, channel);
          if (!(w.start.squaredNorm() > 0.0)) continue;  // begins long after the start
          information.push_back(w.start.squaredNorm());
          found.push_back(w.start.dot(w.residual) / information.back());
          // What noise alone would show is taken off.
          square += found.back() * found.back() - 1.0 / information.back();
        }
      const double variance = found.empty() ? 0.0 : square / static_cast<double>(found.size());
      if (!(variance > 0.0)) continue;
      double gain = 0.0;  // of the log likelihood
      for (std::size_t i = 0; i < found.size(); ++i) {
        const double grown = 1.0 + variance * information[i];
        gain += 0.5 * (found[i] * found[i] * information[i] * (1.0 - 1.0 / grown) - std::log(grown));
      }
      if (gain > most) most = gain, best = {std::sqrt(variance), channel.start.length};
    }
  }
  return starts;
}

int whiten(const RunGrid& grid, const Residual& residual, const NoiseModel& noise, std::vector<double>& out,
           std::vector<int>* block, int first_block, double block_length) {
  const std::vector<Segment> segments = segments_of(grid);
  const auto block_of = [&](int bin) {
    return first_block + static_cast<int>(bin * grid.bin / block_length);
  };
  for (int c = 0; c < channel_rows; ++c) {
    const ChannelNoise& channel = noise[static_cast<std::size_t>(c)];
    for (const Segment& segment : segments) {
      const std::vector<int> bins = measured_bins(grid, c, segment);
      if (bins.empty()) continue;
      const Whitened whitened = whitened_segment(grid, residual, c, segment, bins, channel);
      out.insert(out.end(), whitened.residual.data(), whitened.residual.data() + whitened.residual.size());
      if (block != nullptr)
        for (const int bin : bins) block->push_back(block_of(bin));
    }
  }
  for (std::size_t w = 0; w < grid.windows.size(); ++w) {
    const WindowMean& window = grid.windows[w];
    // A mean over a window carries the offset of its run and little else.
    const ChannelNoise& channel = noise[static_cast<std::size_t>(index_of(window.channel))];
    const double bins = std::max(1.0, (window.end - window.start) / grid.bin);
    const double independent = bins * (1.0 - channel.keep) / (1.0 + channel.keep);
    const double deviation =
        std::hypot(channel.run_offset, channel.deviation / std::sqrt(std::max(1.0, independent)));
    out.push_back(residual.windows[w] / deviation);
    if (block != nullptr) block->push_back(block_of(static_cast<int>(window.start / grid.bin)));
  }
  return block_of(grid.bins()) + 1;
}

}  // namespace wheel_twin::twin
