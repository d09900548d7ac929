// One run of an experiment beside what the twin says it should have read: the twin is led by the run's
// measured motion and load, and every channel that was measured is compared, over time where there is a
// series, over the window where there are averages alone. SI units, frames and signs as in run_log/run_log.h.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "run_log/run_log.h"
#include "twin/channel.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

struct ComparisonOptions {
  double step = 0.02;  ///< longest step of the twin, s
  double low_pass =
      0.25;  ///< measured and twin series are averaged over this before their errors are taken, s
};

/// A channel over time; `twin` has the same stamps.
struct SeriesComparison {
  std::vector<double> time;  ///< s from the start of the run
  std::vector<double> measured;
  std::vector<double> twin;
};

/// A channel in one number.
struct MeanComparison {
  double measured = 0.0;
  double twin = 0.0;
};

struct ChannelComparison {
  std::optional<SeriesComparison>
      series;  ///< where the run has the topic; from the wheel's touch of the soil
  MeanComparison
      mean;  ///< over the window of the averages, else over the time in which the rig moved steadily
  double error =
      0.0;  ///< window averages: |twin - measured|; else RMSE over the time in which the rig moved steadily
  bool from_average = false;
};

struct RunComparison {
  std::string name;  ///< bag, or group and number where there is none
  logs::Run run;
  double load = 0.0;  ///< under which the twin ran, N
  bool measured_load =
      false;  ///< it is the measured mean (then normal_load is no channel to compare), not the declared
  std::array<std::optional<ChannelComparison>, channel_count> channels;
  std::string failure;  ///< why the twin has no prediction; empty: it has one

  const std::optional<ChannelComparison>& at(Channel channel) const { return channels[index_of(channel)]; }
};

/// The twin with its effects and corrections; friction in the guide is taken to be worked loose
/// (slow_course). Speeds that change are left out (run_grid.h). `log`: the run's bag as read, nullptr without
/// one. What the twin cannot predict (an operation outside its contact, a load that the soil does not carry)
/// is told in `failure`.
RunComparison compare_run(const TwinConfig& model, const logs::Run& run, const std::string& name,
                          const run_log::RunLog* log, const ComparisonOptions& options = {});

}  // namespace wheel_twin::twin
