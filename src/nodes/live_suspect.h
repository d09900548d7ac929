// Names the likeliest effect while a rig still runs: keeps the ticks of the run so far on bins of half a
// second and, when the residual has left its band, looks through the catalogue beside the node's own thread
// (twin/likeliest_effect.h).
#pragma once

#include <future>
#include <optional>
#include <string>
#include <vector>

#include "nodes/follower.h"
#include "nodes/rig_setup.h"
#include "twin/likeliest_effect.h"
#include "twin/run_grid.h"

namespace wheel_twin::nodes {

/// How far the channels may leave the twin.
struct SuspectBand {
  double drawbar_pull = 3.0;        ///< N; of all forces
  double hub_displacement = 0.003;  ///< m
  double motor_effort = 0.5;        ///< N m; of torques
};

class LiveSuspect {
 public:
  LiveSuspect(const RigSetup& setup, const SuspectBand& band);

  void add(const Tick& tick);
  void clear();        ///< another run begins
  void ask();          ///< starts a look, when none is under way and the run has grown since the last
  std::string told();  ///< "likeliest effect: bed_tilt, explains 93 %"; empty before the first look has ended

 private:
  void close_bin();
  twin::RunGrid run_so_far() const;

  twin::TwinConfig twin_;
  logs::Run declared_;
  double radius_;
  twin::NoiseModel band_;
  std::vector<rig::MeasuredMotion> motion_;
  std::vector<Eigen::Matrix<double, twin::channel_rows, 1>> measured_;
  // The bin that fills.
  rig::MeasuredMotion sum_;
  Eigen::Matrix<double, twin::channel_rows, 1> value_sum_, value_count_;
  int ticks_ = 0;
  std::size_t asked_bins_ = 0;
  std::future<std::optional<twin::LikeliestEffect>> look_;
  bool stale_ = false;  // the look under way is of an earlier run
  std::string told_;
};

}  // namespace wheel_twin::nodes
