// An experiment: what the operator declared (wheel, soil, sensors) and its runs, as experiment.yaml beside
// the bags. SI units, angles in rad. Declared values are a first guess, not a measurement.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "terramechanics/soil.h"
#include "terramechanics/wheel.h"

namespace wheel_twin::logs {

/// Mean and scatter of a channel over a window; `std` is missing where the source does not give it.
struct Average {
  double mean = 0.0;
  std::optional<double> std;
};

/// Window averages that stand in for topics that a run lacks. Only the channels that were measured are there.
struct Averages {
  double window_start = 0.0;                ///< s from the start of the run
  double window_end = 0.0;                  ///< s, after window_start
  std::optional<Average> drawbar_pull;      ///< N
  std::optional<Average> side_force;        ///< N, to the left
  std::optional<Average> normal_load;       ///< N
  std::optional<Average> hub_displacement;  ///< m, positive down
  std::optional<Average> pitch_torque;      ///< about the sensor's y axis, N m
  std::optional<Average> motor_effort;      ///< N m
};

enum class Role {
  reference,  ///< taken with the rig known to be in order: the twin calibrates on these
  measured,   ///< to be explained
  held_out    ///< never fitted, only scored
};
const char* to_string(Role role);

struct Run {
  std::optional<std::string> bag;  ///< file, relative to the experiment's directory; none: `bag: null`
  Role role = Role::measured;
  double slip = 0.0;            ///< -1 to 1
  double load = 0.0;            ///< declared dead weight on the wheel, N
  double wheel_speed = 0.0;     ///< rad/s
  double steering_angle = 0.0;  ///< rad
  std::string group;  ///< day, filling of the bin or tare; empty: none. What is held out is held out by group
  std::optional<Averages> averages;
};

/// Declared sensor, one scalar for all its axes.
struct DeclaredSensor {
  double rate = 0.0;        ///< Hz
  double noise = 0.0;       ///< standard deviation; N or m
  double resolution = 0.0;  ///< N or m
};

/// A plate or a wheel pressed straight down. Exactly one of bag (wrench and displacement topics) and csv
/// (header line `time_s,depth_m,force_n`) is given. A round plate has a diameter, a rectangular one width and
/// length, others neither.
struct PlateTest {
  std::optional<std::string> bag;
  std::optional<std::string> csv;
  std::string indenter;            ///< plate, wheel or rigid_floor
  std::optional<double> diameter;  ///< m
  std::optional<double> width;     ///< m
  std::optional<double> length;    ///< m
  std::string group;
};

/// A direct shear test; csv has the header line `displacement_m,shear_stress_pa`.
struct DirectShear {
  std::optional<std::string> bag;
  std::optional<std::string> csv;
  double normal_stress = 0.0;  ///< Pa
  std::string group;
};

struct Experiment {
  std::string name;
  terramechanics::Wheel wheel;
  terramechanics::Soil soil;
  std::optional<std::string> wheel_name;  ///< bare name of a file in config/wheels; none: inline
  std::optional<std::string> soil_name;   ///< bare name of a file in config/soils; none: inline
  std::optional<DeclaredSensor> ft;
  std::optional<DeclaredSensor> draw_wire;
  std::string source;  ///< where foreign data come from and under which licence; empty: own
  std::vector<Run> runs;
  std::vector<PlateTest> plate_tests;
  std::vector<DirectShear> direct_shear;
  std::string directory;  ///< of experiment.yaml, for the relative names of bags and CSV; not written

  /// Path of a bag or CSV named in this experiment.
  std::string path_of(const std::string& file) const;
};

/// A planned experiment has conditions; its files need not be there, nor need a run have bag or averages.
enum class Stage { measured, planned };

/// Reads `path`, an experiment.yaml or its directory. A bare wheel or soil name is the file NAME.yaml of
/// `wheels/` or `soils/` in the configuration folder (base/config_path.h). Throws Error naming file, line
/// and key; refuses unknown keys, runs with neither bag nor averages, files outside the directory, and files
/// named twice.
Experiment read_experiment(const std::string& path, Stage stage = Stage::measured);
/// The same of YAML in memory; `directory` holds the files that it names.
Experiment read_experiment(const yaml::Map& map, const std::string& directory, Stage stage = Stage::measured);

/// Writes `experiment.yaml` into `directory` (made when missing), in the form read_experiment reads, whole or
/// not at all.
void write_experiment(const Experiment& experiment, const std::string& directory);

}  // namespace wheel_twin::logs
