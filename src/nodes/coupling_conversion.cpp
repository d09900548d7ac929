#include "nodes/coupling_conversion.h"

#include <fmt/format.h>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

using Eigen::Vector3d;

template <typename Message>
void put(const Vector3d& v, Message& m) {
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
}

template <typename Message>
Vector3d from(const Message& m) {
  return {m.x, m.y, m.z};
}

}  // namespace

void put(const rig::HubMotion& motion, HubMotion& message) {
  message.time = motion.time;
  put(motion.position, message.position);
  put(motion.velocity, message.velocity);
  message.wheel_angle = motion.wheel_angle;
  message.wheel_rate = motion.wheel_rate;
  message.steering_angle = motion.steering_angle;
}

rig::HubMotion from_message(const HubMotion& message) {
  rig::HubMotion motion;
  motion.time = message.time;
  motion.position = from(message.position);
  motion.velocity = from(message.velocity);
  motion.wheel_angle = message.wheel_angle;
  motion.wheel_rate = message.wheel_rate;
  motion.steering_angle = message.steering_angle;
  return motion;
}

void put(const rig::HubLoad& load, HubLoad& message) {
  put(load.force_hub_rig, message.force);
  put(load.torque_hub_rig, message.torque);
  message.drive_torque = load.drive_torque;
}

rig::HubLoad from_message(const HubLoad& message) {
  rig::HubLoad load;
  load.force_hub_rig = from(message.force);
  load.torque_hub_rig = from(message.torque);
  load.drive_torque = message.drive_torque;
  return load;
}

void put(const std::vector<wheel::SegmentState>& segments, SegmentMotion& message) {
  message.poses.resize(segments.size());
  message.twists.resize(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const wheel::SegmentState& s = segments[i];
    put(s.position, message.poses[i].position);
    message.poses[i].orientation.x = s.orientation.x();
    message.poses[i].orientation.y = s.orientation.y();
    message.poses[i].orientation.z = s.orientation.z();
    message.poses[i].orientation.w = s.orientation.w();
    put(s.velocity, message.twists[i].linear);
    put(s.angular_velocity, message.twists[i].angular);
  }
}

std::vector<wheel::SegmentState> from_message(const SegmentMotion& message) {
  if (message.poses.size() != message.twists.size())
    throw Error(fmt::format("step {}: {} poses and {} twists of segments", message.step, message.poses.size(),
                            message.twists.size()));
  std::vector<wheel::SegmentState> segments(message.poses.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto& turn = message.poses[i].orientation;
    segments[i].position = from(message.poses[i].position);
    segments[i].orientation = Eigen::Quaterniond(turn.w, turn.x, turn.y, turn.z);
    segments[i].velocity = from(message.twists[i].linear);
    segments[i].angular_velocity = from(message.twists[i].angular);
  }
  return segments;
}

void put(const std::vector<wheel::Wrench>& loads, SegmentLoads& message) {
  message.segments.resize(loads.size());
  for (std::size_t i = 0; i < loads.size(); ++i) {
    put(loads[i].force, message.segments[i].force);
    put(loads[i].torque, message.segments[i].torque);
  }
}

std::vector<wheel::Wrench> from_message(const SegmentLoads& message) {
  std::vector<wheel::Wrench> loads(message.segments.size());
  for (std::size_t i = 0; i < loads.size(); ++i)
    loads[i] = {from(message.segments[i].force), from(message.segments[i].torque)};
  return loads;
}

}  // namespace wheel_twin::nodes
