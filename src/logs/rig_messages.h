// The messages of a rig log, read from their bytes (little-endian, wiki.ros.org/msg) with every length
// checked: the generated readers allocate what a damaged length asks for.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace wheel_twin::logs {

struct WrenchMessage {
  std::uint64_t stamp = 0;  ///< ns
  Eigen::Vector3d force;
  Eigen::Vector3d torque;
};
struct ScalarMessage {
  std::uint64_t stamp = 0;
  double value = 0.0;
};
struct JointMessage {
  std::uint64_t stamp = 0;
  std::vector<std::string> names;
  std::vector<double> position, velocity, effort;
};

/// All return false when the bytes are not wholly one such message.
bool parse_wrench(const std::uint8_t* data, std::size_t size,
                  WrenchMessage& message);  // geometry_msgs/WrenchStamped
bool parse_displacement(const std::uint8_t* data, std::size_t size,
                        ScalarMessage& message);  // DisplacementStamped
bool parse_temperature(const std::uint8_t* data, std::size_t size,
                       ScalarMessage& message);  // sensor_msgs/Temperature
bool parse_joints(const std::uint8_t* data, std::size_t size,
                  JointMessage& message);  // sensor_msgs/JointState

}  // namespace wheel_twin::logs
