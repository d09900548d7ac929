#include "nodes/msg_conversion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "logs/stamp.h"

namespace wheel_twin::nodes {
namespace {

TEST(MsgConversion, StampsAreThoseOfTheBag) {
  // An epoch of today and times of a 1 kHz sensor: the nanoseconds that logs/stamp.h writes.
  const double epoch = 1703240800.123457;
  for (int i = 0; i < 5000; i += 7) {
    const double time = 0.001 * i;
    EXPECT_EQ(to_nanoseconds(to_stamp(epoch, time)), logs::to_nanoseconds(epoch, time));
  }
  EXPECT_EQ(to_stamp(1700000000.0, 0.25).sec, 1700000000u);
  EXPECT_EQ(to_stamp(1700000000.0, 0.25).nsec, 250000000u);
  EXPECT_THROW(to_stamp(std::int64_t{-1}), Error);
  EXPECT_THROW(to_stamp(std::int64_t{4294967296} * 1000000000), Error);
}

TEST(MsgConversion, WrenchKeepsEveryAxisAndSign) {
  const auto message = to_message(ros::Time(5, 6), "ft_sensor", {1, -2, 3}, {-4, 5, -6});
  EXPECT_EQ(message.header.frame_id, "ft_sensor");
  EXPECT_EQ(message.header.stamp, ros::Time(5, 6));
  EXPECT_EQ(message.wrench.force.y, -2);
  EXPECT_EQ(message.wrench.torque.z, -6);
  const auto reading = from_message(message);
  EXPECT_EQ(reading.force, Eigen::Vector3d(1, -2, 3));
  EXPECT_EQ(reading.torque, Eigen::Vector3d(-4, 5, -6));
}

TEST(MsgConversion, JointsGoByName) {
  sensor_msgs::JointState message;
  message.name = {"wheel", "gripper", "carriage"};
  message.position = {1.0, 9.0, 2.0};
  message.velocity = {3.0, 9.0, 4.0};
  message.effort = {5.0, 9.0, 9.0};
  const auto joints = from_message(message);
  ASSERT_TRUE(joints);
  EXPECT_EQ(joints->carriage_position, 2.0);
  EXPECT_EQ(joints->carriage_velocity, 4.0);
  EXPECT_EQ(joints->wheel_angle, 1.0);
  EXPECT_EQ(joints->wheel_rate, 3.0);
  EXPECT_EQ(joints->wheel_effort, 5.0);
}

TEST(MsgConversion, JointsThatLackSomething) {
  rig::JointReading reading;
  reading.wheel_effort = 1.0;
  sensor_msgs::JointState whole = to_message(ros::Time(1, 0), reading);
  ASSERT_TRUE(from_message(whole));
  EXPECT_EQ(from_message(whole)->wheel_effort, 1.0);
  sensor_msgs::JointState no_effort = whole;
  no_effort.effort.clear();
  ASSERT_TRUE(from_message(no_effort));
  EXPECT_TRUE(std::isnan(from_message(no_effort)->wheel_effort));
  sensor_msgs::JointState no_velocity = whole;
  no_velocity.velocity.clear();
  EXPECT_FALSE(from_message(no_velocity));
  sensor_msgs::JointState renamed = whole;
  renamed.name[0] = "cart";
  EXPECT_FALSE(from_message(renamed));
  EXPECT_FALSE(from_message(sensor_msgs::JointState()));
}

TEST(MsgConversion, PoseNamesTheJointsOfTheModel) {
  const auto message = to_message(ros::Time(1, 0), ModelPose{0.1, 0.2, 0.3, 0.4});
  EXPECT_EQ(message.name, (std::vector<std::string>{"carriage", "slide", "steering", "wheel"}));
  EXPECT_EQ(message.position, (std::vector<double>{0.1, 0.2, 0.3, 0.4}));
}

}  // namespace
}  // namespace wheel_twin::nodes
