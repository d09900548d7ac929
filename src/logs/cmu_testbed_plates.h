// The testbed's pressings (plates, wheels, rigid floor) as logs in rig axes: tared, cut to the stroke, force
// and depth on one clock.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "logs/cmu_testbed_tables.h"
#include "run_log/run_log.h"

namespace wheel_twin::logs::cmu {

struct Pressing {
  PlateRow row;
  std::string name;  ///< file without folder
  std::string box;  ///< filling of the bin: the part of the name before the first word that is not of the box
  run_log::RunLog
      log;  ///< ft: load +z, tared; draw_wire: depth below the surface (rigid floor: below the first reading)
  std::optional<double> lag;  ///< s that the kinematics' stamps are behind the F/T bag's, where the data tell
  bool has_eighth_column = false;
  double weight_before =
      0.0;  ///< normal load before contact, tared by the zero bag and the offset, N: 0 in a good tare
};

/// Reads every pressing of plates.csv whose files are there; the others are named in `remarks`. The lag is
/// found for each (see align_lag), and the median over all is applied to all.
std::vector<Pressing> read_pressings(const std::string& directory, std::vector<std::string>& remarks);

/// The lag of `depth` behind `force`, s: that for which force is the best smooth function (a polynomial of
/// degree 7) of depth over the stroke, in steps of 10 ms within +-0.3 s. None when the minimum lies at the
/// edge or is flat.
std::optional<double> align_lag(const run_log::ScalarSeries& force, const run_log::ScalarSeries& depth);

}  // namespace wheel_twin::logs::cmu
