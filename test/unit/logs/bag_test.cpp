// A bag that is written, read back, and read by rosbag itself.
#include <geometry_msgs/WrenchStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "logs/bag_reader.h"
#include "logs/bag_scanner.h"
#include "logs/bag_writer.h"
#include "logs/topics.h"
#include "support.h"

namespace wheel_twin::logs {
namespace {

using testing::AllOf;
using testing::HasSubstr;

void expect_same(const run_log::RunLog& a, const run_log::RunLog& b) {
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.ft.time, b.ft.time);
  EXPECT_EQ(a.ft.force, b.ft.force);
  EXPECT_EQ(a.ft.torque, b.ft.torque);
  EXPECT_EQ(a.draw_wire.time, b.draw_wire.time);
  EXPECT_EQ(a.draw_wire.value, b.draw_wire.value);
  EXPECT_EQ(a.joints.time, b.joints.time);
  EXPECT_EQ(a.joints.carriage_position, b.joints.carriage_position);
  EXPECT_EQ(a.joints.carriage_velocity, b.joints.carriage_velocity);
  EXPECT_EQ(a.joints.wheel_angle, b.joints.wheel_angle);
  EXPECT_EQ(a.joints.wheel_rate, b.joints.wheel_rate);
  EXPECT_EQ(a.joints.wheel_effort, b.joints.wheel_effort);
  EXPECT_EQ(a.temperature.value, b.temperature.value);
}

class BagRoundTrip : public testing::TestWithParam<Compression> {
 protected:
  Scratch scratch_;
};

TEST_P(BagRoundTrip, ReadsBackWhatWasWritten) {
  const run_log::RunLog log = sound_run();
  write_bag(log, scratch_ / "a.bag", GetParam());
  const Recording recording = read_recording(scratch_ / "a.bag");
  ASSERT_EQ(recording.defects.size(), GetParam() == Compression::none ? 1u : 0u);
  for (const Defect& defect : recording.defects) EXPECT_EQ(defect.kind, Defect::Kind::no_checksum);
  EXPECT_TRUE(recording.other_topics.empty());
  expect_same(recording.log, log);
  EXPECT_EQ(recording.ft_arrival, log.ft.time);
  expect_same(read_run_log(scratch_ / "a.bag"), log);
}

TEST_P(BagRoundTrip, GivesTheSameBytesForTheSameLog) {
  write_bag(sound_run(), scratch_ / "a.bag", GetParam());
  write_bag(sound_run(), scratch_ / "b.bag", GetParam());
  EXPECT_EQ(bytes_of(scratch_ / "a.bag"), bytes_of(scratch_ / "b.bag"));
}

TEST_P(BagRoundTrip, IsReadByRosbagMessageForMessage) {
  const run_log::RunLog log = sound_run();
  write_bag(log, scratch_ / "a.bag", GetParam());
  rosbag::Bag bag(scratch_ / "a.bag");
  rosbag::View wrenches(bag, rosbag::TopicQuery(wrench_topic));
  std::size_t i = 0;
  for (const rosbag::MessageInstance& instance : wrenches) {
    const auto message = instance.instantiate<geometry_msgs::WrenchStamped>();
    ASSERT_TRUE(message);
    ASSERT_LT(i, log.ft.time.size());
    EXPECT_EQ(message->wrench.force.z, log.ft.force[i].z());
    EXPECT_EQ(message->header.stamp, instance.getTime());
    EXPECT_EQ(message->header.frame_id, "ft_sensor");
    EXPECT_EQ(message->header.seq, i);
    ++i;
  }
  EXPECT_EQ(i, log.ft.time.size());
  EXPECT_EQ(rosbag::View(bag).size(), 3 * log.ft.time.size() + log.temperature.time.size());
}

TEST_P(BagRoundTrip, ScanAndRosbagViewSeeTheSameMessages) {
  write_bag(sound_run(60.0), scratch_ / "a.bag", GetParam());
  std::vector<std::pair<std::uint64_t, std::string>> scanned;
  const ScanSummary summary = scan_bag(scratch_ / "a.bag", [&](const BagMessage& m) {
    scanned.emplace_back(m.time, m.connection->topic + std::string(m.data, m.data + m.size));
  });
  EXPECT_TRUE(summary.intact());
  EXPECT_GT(summary.chunks, 2u);
  EXPECT_EQ(summary.has_uncompressed_chunks, GetParam() == Compression::none);
  rosbag::Bag bag(scratch_ / "a.bag");
  std::vector<std::pair<std::uint64_t, std::string>> viewed;
  for (const rosbag::MessageInstance& instance : rosbag::View(bag)) {
    std::string bytes(instance.size(), '\0');
    ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()), instance.size());
    instance.write(stream);
    viewed.emplace_back(instance.getTime().toNSec(), instance.getTopic() + bytes);
  }
  std::sort(scanned.begin(), scanned.end());
  std::sort(viewed.begin(), viewed.end());
  EXPECT_EQ(scanned, viewed);
}

std::string name_of(const testing::TestParamInfo<Compression>& parameter) {
  if (parameter.param == Compression::none) return "none";
  return parameter.param == Compression::bz2 ? "bz2" : "lz4";
}

INSTANTIATE_TEST_SUITE_P(Compressions, BagRoundTrip,
                         testing::Values(Compression::none, Compression::bz2, Compression::lz4), name_of);

class BagFile : public testing::Test {
 protected:
  Scratch scratch_;
};

TEST_F(BagFile, LiveWriterGivesTheBagItsNameAtTheEnd) {
  const run_log::RunLog log = sound_run(4.0);
  {
    BagWriter writer(scratch_ / "a.bag", log.epoch);
    for (std::size_t i = 0; i < log.ft.time.size(); ++i)
      writer.wrench(log.ft.time[i], log.ft.force[i], log.ft.torque[i]);
    writer.displacement(1.0, 0.01);
    writer.joints(1.0, {1.0, 2.0, 3.0, 4.0, 5.0});
    writer.temperature(1.0, 20.0);
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "a.bag"));
    writer.close();
    EXPECT_THAT(message_of([&] { writer.temperature(1.0, 20.0); }),
                AllOf(HasSubstr("a.bag"), HasSubstr("closed")));
  }
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "a.bag.active"));
  const Recording recording = read_recording(scratch_ / "a.bag");
  EXPECT_TRUE(recording.defects.empty());
  EXPECT_EQ(recording.log.ft.force, log.ft.force);
  EXPECT_EQ(recording.log.joints.wheel_effort, std::vector<double>{5.0});
}

TEST_F(BagFile, LiveWriterKeepsWhatWasMeasuredWhenItIsNotClosed) {
  {
    BagWriter writer(scratch_ / "a.bag", 1e9);
    writer.displacement(1.0, 0.01);
  }
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "a.bag"));
  EXPECT_EQ(read_recording(scratch_ / "a.bag.active").log.draw_wire.value, std::vector<double>{0.01});
}

TEST_F(BagFile, RefusesWhatCannotBeALog) {
  run_log::RunLog log = sound_run(1.0);
  log.epoch = 0.0;
  EXPECT_THAT(message_of([&] { write_bag(log, scratch_ / "a.bag"); }),
              AllOf(HasSubstr("a.bag"), HasSubstr("no ROS time")));
  log.epoch = 1e9;
  log.ft.time[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of([&] { write_bag(log, scratch_ / "a.bag"); }), HasSubstr("no ROS time"));
  log = sound_run(1.0);
  log.joints.wheel_rate.pop_back();
  EXPECT_THAT(message_of([&] { write_bag(log, scratch_ / "a.bag"); }), HasSubstr(joints_topic));
  EXPECT_THAT(message_of([&] { write_bag(sound_run(1.0), scratch_ / "none/a.bag"); }),
              HasSubstr("cannot be written"));
  EXPECT_TRUE(std::filesystem::is_empty(scratch_.path()));
}

TEST_F(BagFile, AColumnThatWasNotLoggedIsEmpty) {
  run_log::RunLog log = sound_run(1.0);
  log.joints.wheel_effort.clear();
  log.temperature = {};
  write_bag(log, scratch_ / "a.bag");
  const run_log::RunLog back = read_run_log(scratch_ / "a.bag");
  EXPECT_TRUE(back.joints.wheel_effort.empty());
  EXPECT_EQ(back.joints.wheel_rate, log.joints.wheel_rate);
  EXPECT_TRUE(back.temperature.time.empty());
}

TEST(Cleaned, SortsDropsRepeatsAndWhatIsNotFinite) {
  run_log::RunLog log;
  log.draw_wire.time = {0.0, 2.0, 1.0, 1.0, 3.0};
  log.draw_wire.value = {0.0, 20.0, 10.0, 11.0, std::numeric_limits<double>::infinity()};
  const run_log::RunLog clean = cleaned(log);
  EXPECT_EQ(clean.draw_wire.time, (std::vector<double>{0.0, 1.0, 2.0}));
  EXPECT_EQ(clean.draw_wire.value, (std::vector<double>{0.0, 10.0, 20.0}));
}

}  // namespace
}  // namespace wheel_twin::logs
