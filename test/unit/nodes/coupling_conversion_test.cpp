// What passes between rig, wheel and soil comes through serialised messages with every bit.
#include "nodes/coupling_conversion.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

using Eigen::Vector3d;

template <typename Message>
Message through_the_wire(const Message& message) {
  const ros::SerializedMessage wire = ros::serialization::serializeMessage(message);
  Message back;
  ros::serialization::IStream stream(wire.message_start, static_cast<std::uint32_t>(wire.num_bytes - 4));
  ros::serialization::deserialize(stream, back);
  return back;
}

TEST(CouplingConversion, MotionAndLoadOfTheHub) {
  rig::HubMotion motion;
  motion.time = 1.0 / 3.0;
  motion.position = {0.1, -0.0, 1e-310};
  motion.velocity = {-0.3, 0.7, 0.9};
  motion.wheel_angle = 1.1;
  motion.wheel_rate = 0.1 + 0.2;
  motion.steering_angle = -0.05;
  HubMotion question;
  put(motion, question);
  const rig::HubMotion back = from_message(through_the_wire(question));
  EXPECT_EQ(back.time, motion.time);
  EXPECT_EQ(back.position, motion.position);
  EXPECT_TRUE(std::signbit(back.position.y()));
  EXPECT_EQ(back.velocity, motion.velocity);
  EXPECT_EQ(back.wheel_angle, motion.wheel_angle);
  EXPECT_EQ(back.wheel_rate, motion.wheel_rate);
  EXPECT_EQ(back.steering_angle, motion.steering_angle);

  rig::HubLoad load;
  load.force_hub_rig = {1.0 / 7.0, 2.0 / 7.0, 3.0 / 7.0};
  load.torque_hub_rig = {4.0 / 7.0, 5.0 / 7.0, 6.0 / 7.0};
  load.drive_torque = -5.0 / 7.0;
  HubLoad answer;
  put(load, answer);
  const rig::HubLoad same = from_message(through_the_wire(answer));
  EXPECT_EQ(same.force_hub_rig, load.force_hub_rig);
  EXPECT_EQ(same.torque_hub_rig, load.torque_hub_rig);
  EXPECT_EQ(same.drive_torque, load.drive_torque);
}

TEST(CouplingConversion, SegmentsAndTheirLoads) {
  std::vector<wheel::SegmentState> segments(3);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const double x = 1.0 / (3.0 + static_cast<double>(i));
    segments[i].position = {x, x * x, -x};
    segments[i].orientation = Eigen::AngleAxisd(x, Vector3d(1.0, 2.0, 3.0).normalized());
    segments[i].velocity = {2.0 * x, 3.0 * x, 5.0 * x};
    segments[i].angular_velocity = {7.0 * x, 11.0 * x, 13.0 * x};
  }
  SegmentMotion question;
  put(segments, question);
  const auto back = from_message(through_the_wire(question));
  ASSERT_EQ(back.size(), segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    EXPECT_EQ(back[i].position, segments[i].position);
    EXPECT_EQ(back[i].orientation.coeffs(), segments[i].orientation.coeffs());
    EXPECT_EQ(back[i].velocity, segments[i].velocity);
    EXPECT_EQ(back[i].angular_velocity, segments[i].angular_velocity);
  }
  question.twists.pop_back();
  EXPECT_THROW(from_message(question), Error);

  const std::vector<wheel::Wrench> loads{{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}},
                                         {{0.7, 0.8, 0.9}, {1.1, 1.2, 1.3}}};
  SegmentLoads answer;
  put(loads, answer);
  const auto same = from_message(through_the_wire(answer));
  ASSERT_EQ(same.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(same[i].force, loads[i].force);
    EXPECT_EQ(same[i].torque, loads[i].torque);
  }
}

}  // namespace
}  // namespace wheel_twin::nodes
