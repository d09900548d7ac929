#include "nodes/msg_conversion.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "logs/stamp.h"

namespace wheel_twin::nodes {
namespace {

constexpr std::int64_t second = 1000000000;

}  // namespace

ros::Time to_stamp(std::int64_t nanoseconds) {
  if (nanoseconds < 0 || nanoseconds / second > std::numeric_limits<std::uint32_t>::max())
    throw Error(fmt::format("{} ns is no ROS time", nanoseconds));
  return {static_cast<std::uint32_t>(nanoseconds / second), static_cast<std::uint32_t>(nanoseconds % second)};
}

ros::Time to_stamp(double epoch, double time) {
  return to_stamp(logs::to_nanoseconds(epoch, time));
}

std::int64_t to_nanoseconds(const ros::Time& stamp) {
  return static_cast<std::int64_t>(stamp.sec) * second + static_cast<std::int64_t>(stamp.nsec);
}

geometry_msgs::WrenchStamped to_message(const ros::Time& stamp, const std::string& frame,
                                        const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  geometry_msgs::WrenchStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.wrench.force.x = force.x();
  message.wrench.force.y = force.y();
  message.wrench.force.z = force.z();
  message.wrench.torque.x = torque.x();
  message.wrench.torque.y = torque.y();
  message.wrench.torque.z = torque.z();
  return message;
}

rig::WrenchReading from_message(const geometry_msgs::WrenchStamped& message) {
  const auto& force = message.wrench.force;
  const auto& torque = message.wrench.torque;
  return {{force.x, force.y, force.z}, {torque.x, torque.y, torque.z}};
}

DisplacementStamped to_message(const ros::Time& stamp, const std::string& frame, double displacement) {
  DisplacementStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.displacement = displacement;
  return message;
}

sensor_msgs::JointState to_message(const ros::Time& stamp, const rig::JointReading& joints) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.header.frame_id = "rig";
  message.name = {"carriage", "wheel"};
  message.position = {joints.carriage_position, joints.wheel_angle};
  message.velocity = {joints.carriage_velocity, joints.wheel_rate};
  message.effort = {0.0, joints.wheel_effort};
  return message;
}

std::optional<rig::JointReading> from_message(const sensor_msgs::JointState& message) {
  const auto index_of = [&](const char* name) {
    return static_cast<std::size_t>(std::find(message.name.begin(), message.name.end(), name) -
                                    message.name.begin());
  };
  const std::size_t carriage = index_of("carriage");
  const std::size_t wheel = index_of("wheel");
  const std::size_t needed = std::max(carriage, wheel);
  if (needed >= message.name.size() || needed >= message.position.size() || needed >= message.velocity.size())
    return std::nullopt;
  rig::JointReading joints;
  joints.carriage_position = message.position[carriage];
  joints.carriage_velocity = message.velocity[carriage];
  joints.wheel_angle = message.position[wheel];
  joints.wheel_rate = message.velocity[wheel];
  joints.wheel_effort =
      wheel < message.effort.size() ? message.effort[wheel] : std::numeric_limits<double>::quiet_NaN();
  return joints;
}

sensor_msgs::Temperature to_temperature(const ros::Time& stamp, double celsius) {
  sensor_msgs::Temperature message;
  message.header.stamp = stamp;
  message.header.frame_id = "rig";
  message.temperature = celsius;
  return message;
}

sensor_msgs::JointState to_message(const ros::Time& stamp, const ModelPose& pose) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.header.frame_id = "rig";
  message.name = {"carriage", "slide", "steering", "wheel"};
  message.position = {pose.carriage, pose.hub_height, pose.steering, pose.wheel_angle};
  return message;
}

}  // namespace wheel_twin::nodes
