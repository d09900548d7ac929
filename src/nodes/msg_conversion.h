// Between what rig and log know (SI, seconds since an epoch) and ROS messages. The only place where either
// becomes the other. Signs and frames as in run_log/run_log.h; nothing is scaled.
#pragma once

#include <geometry_msgs/WrenchStamped.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Temperature.h>
#include <wheel_twin/DisplacementStamped.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "rig/ports.h"
#include "rig/step.h"

namespace wheel_twin::nodes {

/// Stamp of `time` s after `epoch` (ROS time, s): the same nanosecond as a bag written from the same log has.
ros::Time to_stamp(double epoch, double time);

/// A stamp that far after ROS time 0. Throws Error before 0 or beyond what ROS time holds.
ros::Time to_stamp(std::int64_t nanoseconds);
std::int64_t to_nanoseconds(const ros::Time& stamp);

geometry_msgs::WrenchStamped to_message(const ros::Time& stamp, const std::string& frame,
                                        const Eigen::Vector3d& force, const Eigen::Vector3d& torque);
rig::WrenchReading from_message(const geometry_msgs::WrenchStamped& message);

DisplacementStamped to_message(const ros::Time& stamp, const std::string& frame, double displacement);

/// Joints `carriage` and `wheel`, the effort of the wheel only.
sensor_msgs::JointState to_message(const ros::Time& stamp, const rig::JointReading& joints);
/// By joint name, in any order and among others. Nothing when a joint, its position or its velocity is
/// missing; a missing effort is NaN.
std::optional<rig::JointReading> from_message(const sensor_msgs::JointState& message);

sensor_msgs::Temperature to_temperature(const ros::Time& stamp, double celsius);

/// Joints of urdf/single_wheel_rig.urdf, for robot_state_publisher.
struct ModelPose {
  double carriage = 0.0;     ///< m along x
  double hub_height = 0.0;   ///< of the hub over the undisturbed soil, m
  double steering = 0.0;     ///< rad
  double wheel_angle = 0.0;  ///< rad
};
sensor_msgs::JointState to_message(const ros::Time& stamp, const ModelPose& pose);

}  // namespace wheel_twin::nodes
