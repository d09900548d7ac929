// Force and torque of the testbed's sensor (Bota Rokubi, driver rokubimini) from a bag, and their way into
// rig axes. The message is read by the definition in the bag: its field order differs between versions of the
// driver.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

namespace wheel_twin::logs::cmu {

/// As recorded: sensor axes, not tared.
struct FtRecording {
  std::vector<double> time;                     ///< header stamps, s since the epoch (UTC), increasing
  std::vector<Eigen::Vector3d> force;           ///< N
  std::vector<Eigen::Vector3d> torque;          ///< N m
  std::vector<double> temperature;              ///< of the sensor, degrees C
  Eigen::Vector3d acceleration{0.0, 0.0, 0.0};  ///< mean of its accelerometer, in g
  std::size_t saturated = 0;                    ///< samples flagged by the sensor
  std::size_t dropped = 0;  ///< samples with a stamp not after the one before, or not finite
};

/// Throws Error naming file and topic when the bag cannot be read or holds no force and torque.
FtRecording read_ft(const std::string& path);

/// Mean reading of a bag, the wheel hanging.
struct Tare {
  Eigen::Vector3d force{0.0, 0.0, 0.0};  ///< sensor axes, N
  Eigen::Vector3d torque{0.0, 0.0, 0.0};
  Eigen::Vector3d force_std{0.0, 0.0, 0.0};
  double temperature = 0.0;
  double time = 0.0;  ///< s since the epoch (UTC) of the first sample
};
Tare tare_of(const FtRecording& recording);

/// From sensor to rig axes: x along travel is -y of the sensor, y to the left is -x, z up is -z. A rotation
/// (the sensor's accelerometer reads -1 g along its z when the wheel hangs, so its z points down; drawbar
/// pull is -Fy by the authors; a right-handed sensor leaves -x to the left).
Eigen::Vector3d to_rig_axes(const Eigen::Vector3d& sensor);

}  // namespace wheel_twin::logs::cmu
