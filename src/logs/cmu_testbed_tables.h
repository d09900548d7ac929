// The tables of the single-wheel testbed of the Robomechanics Lab, Carnegie Mellon University, as they lie on
// disk: runs.csv, plates.csv and the kinematics of a run. Units and signs are those of the files, named in
// the members; cmu_testbed.h turns them into ours.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace wheel_twin::logs::cmu {

/// Mean and standard deviation over a run's window.
struct MeanStd {
  double mean = 0.0;
  double std = 0.0;
};

/// One line of runs.csv: a driving run.
struct RunRow {
  std::string wheel;  ///< smooth or grouser
  std::string day;    ///< YYYY-MM-DD
  std::string file;   ///< <Vx>_<Vry>_<beta>_<trial>
  double vry_command_mm_s = 0.0;
  double beta_deg = 0.0;
  double angle_deg = 0.0;  ///< measured steering angle
  double slip = 0.0;
  double vx_mm_s = 0.0;
  double vry_mm_s = 0.0;
  MeanStd tractive_n;
  MeanStd lateral_n;
  MeanStd load_n;
  MeanStd sinkage_mm;
  double window_start_s = 0.0;  ///< from the first row of the kinematics
  double window_end_s = 0.0;
  double z0_mm = 0.0;              ///< Z of the first row
  double start_epoch_local = 0.0;  ///< computer time of the first row, s, local
  double rate_hz = 0.0;
  double duration_s = 0.0;
};

/// One line of plates.csv: an indenter pressed straight into the sand, or the rig onto a rigid floor.
struct PlateRow {
  std::string file;      ///< without ending, relative to the data set
  std::string indenter;  ///< plate, wheel_smooth, wheel_grouser or rigid_floor
  std::optional<double> diameter_mm;
  double stroke_start_s = 0.0;  ///< from the first stamp of the F/T bag
  double stroke_end_s = 0.0;
  std::optional<double> z_surface_mm;
  double force_offset_n = 0.0;  ///< to be added to sensor Fz after taring
  double clock_behind_utc_h = 0.0;
};

/// Kinematics of one run or pressing, as logged.
struct Kinematics {
  std::vector<double> x_mm, vx_mm_s, vry_mm_s, steering_deg, z_mm;
  std::vector<double> controller_s;  ///< controller clock
  std::vector<double> computer_s;    ///< epoch of the computer, local time
  bool has_eighth_column = false;    ///< in some pressings: a constant, not known and not used
  std::size_t size() const { return x_mm.size(); }
};

/// All throw Error naming file, line and column when the table is missing, a column is missing, a row has
/// another number of fields than the header, or a field is not what its column holds. Unknown columns are
/// named in `remarks`.
std::vector<RunRow> read_runs(const std::string& path, std::vector<std::string>& remarks);
std::vector<PlateRow> read_plates(const std::string& path, std::vector<std::string>& remarks);

/// Rows that are incomplete, not numbers or go back in controller time are left out and counted in `remarks`.
/// Throws Error when the file cannot be read or holds fewer than 10 good rows.
Kinematics read_kinematics(const std::string& path, std::vector<std::string>& remarks);

}  // namespace wheel_twin::logs::cmu
