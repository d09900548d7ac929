// Writes the log of one run as the bag of a rig: topics /ft_sensor/wrench, /draw_wire/displacement,
// /rig/joint_states and /rig/temperature in lz4-compressed chunks, messages in the order of their stamps, bag
// time equal to header stamp. The same log gives the same bytes. Units and signs as in run_log/run_log.h.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "logs/compression.h"
#include "run_log/run_log.h"

namespace wheel_twin::logs {

/// Writes `log` to `path`, whole or not at all. An empty series writes no topic. Throws Error naming the file
/// when a series has columns of different length, a stamp is not after ROS time 0, or the file cannot be
/// written.
void write_bag(const run_log::RunLog& log, const std::string& path,
               Compression compression = Compression::lz4);

/// Appends messages while a run goes on. Writes to `path`.active, which close() renames to `path`; when it is
/// destroyed without close(), the bag is finished under the name `path`.active, so that nothing measured is
/// lost.
class BagWriter {
 public:
  /// `epoch`: ROS time of time 0, s, above 0. Throws Error when the file cannot be created.
  BagWriter(std::string path, double epoch, Compression compression = Compression::lz4);
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  struct Joints {
    double carriage_position = 0.0;  ///< m
    double carriage_velocity = 0.0;  ///< m/s
    double wheel_angle = 0.0;        ///< rad
    double wheel_rate = 0.0;         ///< rad/s
    double wheel_effort = 0.0;       ///< N m at the motor
  };

  /// `time` in s since the epoch. All throw Error when the disk is full or the stamp is not after ROS time 0.
  void wrench(double time, const Eigen::Vector3d& force, const Eigen::Vector3d& torque);
  void displacement(double time, double value);
  void joints(double time, const Joints& joints);
  void temperature(double time, double celsius);

  void close();  ///< writes the index and gives the bag its name; further messages are refused

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::logs
