// The inputs that a log tool must survive with one clear line and nothing lost that is intact: each is made
// here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Temperature.h>
#include <std_msgs/Float64.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <wheel_twin/DisplacementStamped.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "logs/bag_file.h"
#include "logs/bag_reader.h"
#include "logs/bag_scanner.h"
#include "logs/bag_writer.h"
#include "logs/check.h"
#include "logs/salvage.h"
#include "logs/topics.h"
#include "support.h"

namespace wheel_twin::logs {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr Compression all_compressions[] = {Compression::none, Compression::bz2, Compression::lz4};

std::vector<std::string> messages_of(const std::string& path, ScanSummary* summary = nullptr) {
  std::vector<std::string> messages;
  const ScanSummary result = scan_bag(path, [&](const BagMessage& m) {
    messages.push_back(std::to_string(m.time) + m.connection->topic + std::string(m.data, m.data + m.size));
  });
  if (summary != nullptr) *summary = result;
  return messages;
}

bool is_prefix(const std::vector<std::string>& part, const std::vector<std::string>& all) {
  return part.size() <= all.size() && std::equal(part.begin(), part.end(), all.begin());
}

bool is_subsequence(const std::vector<std::string>& part, const std::vector<std::string>& all) {
  auto next = all.begin();
  for (const std::string& message : part) {
    next = std::find(next, all.end(), message);
    if (next == all.end()) return false;
    ++next;
  }
  return true;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::vector<std::size_t> places_of(const std::string& text, const std::string& part) {
  std::vector<std::size_t> places;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) places.push_back(at);
  return places;
}

const std::string message_op("\x04\0\0\0op=\x02", 8);
const std::string chunk_op("\x04\0\0\0op=\x05", 8);

/// Runs `action` in a process of its own that may use `extra` bytes more than it has at the start. Returns
/// what it printed as one line: the message of its Error, or "no error".
std::string in_little_memory(std::size_t extra, const std::function<void()>& action) {
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    rusage before{};
    getrusage(RUSAGE_SELF, &before);
#if !defined(__SANITIZE_ADDRESS__)
    long pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t limit = static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + extra;
    const rlimit space{limit, limit};
    setrlimit(RLIMIT_AS, &space);
#endif
    std::string said = "no error";
    try {
      action();
    } catch (const Error& error) {
      said = error.what();
    } catch (const std::exception& error) {
      said = std::string("not an Error: ") + error.what();
    }
    rusage after{};
    getrusage(RUSAGE_SELF, &after);
    if (static_cast<std::size_t>(after.ru_maxrss - before.ru_maxrss) * 1024 > extra)
      said = "used too much memory";
    if (write(pipe_ends[1], said.data(), said.size()) < 0) _exit(2);
    _exit(0);
  }
  close(pipe_ends[1]);
  std::string said;
  char buffer[4096];
  for (ssize_t got = 0; (got = read(pipe_ends[0], buffer, sizeof(buffer))) > 0;)
    said.append(buffer, static_cast<std::size_t>(got));
  close(pipe_ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? said : "it crashed";
}

bool has(const CheckReport& report, Severity severity, const std::string& kind, const std::string& topic) {
  return std::any_of(report.findings.begin(), report.findings.end(), [&](const Finding& f) {
    return f.severity == severity && f.kind == kind && f.topic == topic;
  });
}

class BadInput : public testing::Test {
 protected:
  std::string bag(Compression compression, double duration = 60.0) {
    const std::string path = scratch_ / "run.bag";
    write_bag(sound_run(duration), path, compression);
    return path;
  }
  Scratch scratch_;
};

// 1. A recorder killed.

TEST_F(BadInput, RosbagKilledWhileRecordingLosesOnlyWhatNeverReachedTheFile) {
  for (const Compression compression : all_compressions) {
    const std::string path = scratch_ / "run.bag.active";
    const pid_t child = fork();
    if (child == 0) {
      rosbag::Bag recorder(path, rosbag::bagmode::Write);
      recorder.setCompression(compression == Compression::none  ? rosbag::compression::Uncompressed
                              : compression == Compression::bz2 ? rosbag::compression::BZ2
                                                                : rosbag::compression::LZ4);
      recorder.setChunkThreshold(20000);
      DisplacementStamped message;
      for (unsigned i = 0; i < 1000; ++i) {
        message.header.stamp = ros::Time(1000 + i);
        message.displacement = i;
        recorder.write(displacement_topic, message.header.stamp, message);
      }
      kill(getpid(), SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    const std::string bytes = bytes_of(path);
    const Recording recording = read_recording(path);
    const std::size_t read = recording.log.draw_wire.value.size();
    for (std::size_t i = 0; i < read; ++i)
      ASSERT_EQ(recording.log.draw_wire.value[i], static_cast<double>(i));
    if (compression == Compression::none) {
      // What the file holds, counted by another way: message headers, the last of which may lack its data.
      EXPECT_GE(read + 1, count_of(bytes, message_op));
      EXPECT_GT(read, 900u);
    } else {
      // A chunk of 20000 bytes holds about 200 of these messages; the unfinished one may be lost.
      EXPECT_GT(read, 750u);
    }
    EXPECT_FALSE(check_bag(path).fit());
    const Salvage salvage = salvage_bag(path);
    EXPECT_EQ(salvage.output, scratch_ / "run.salvaged.bag");
    EXPECT_EQ(salvage.written.at(displacement_topic), read);
    ScanSummary summary;
    EXPECT_EQ(messages_of(salvage.output, &summary), messages_of(path));
    EXPECT_TRUE(summary.intact());
    std::filesystem::remove(salvage.output);
  }
}

TEST_F(BadInput, OwnRecorderKilledLosesLessThanOneChunk) {
  const std::string path = scratch_ / "run.bag";
  const pid_t child = fork();
  if (child == 0) {
    BagWriter writer(path, 1e9);
    for (int i = 0; i < 20000; ++i) writer.displacement(0.001 * i, i);
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  const Recording recording = read_recording(path + ".active");
  // 256 KiB hold 2600 of these messages (101 bytes each).
  EXPECT_GT(recording.log.draw_wire.value.size(), 20000u - 2700u);
  EXPECT_EQ(recording.log.draw_wire.value.back(),
            static_cast<double>(recording.log.draw_wire.value.size() - 1));
}

// 2. A truncated bag.

TEST_F(BadInput, TailCutOffLosesNoMessage) {
  for (const Compression compression : all_compressions) {
    const std::string path = bag(compression);
    const std::vector<std::string> all = messages_of(path);
    const std::string bytes = bytes_of(path);
    put_bytes(path, bytes.substr(0, bytes.size() - 200));
    EXPECT_EQ(messages_of(path), all);
    EXPECT_TRUE(has(check_bag(path), Severity::error, "damage", ""));
    EXPECT_EQ(messages_of(salvage_bag(path).output), all);
    std::filesystem::remove(salvaged_name(path));
  }
}

TEST_F(BadInput, CutInTheMiddleGivesWhatStandsBeforeTheCut) {
  for (const Compression compression : all_compressions) {
    const std::string path = bag(compression);
    const std::vector<std::string> all = messages_of(path);
    const std::string bytes = bytes_of(path);
    const std::vector<std::size_t> chunks = places_of(bytes, chunk_op);
    ASSERT_GE(chunks.size(), 4u);
    for (const std::size_t cut : {chunks[2] + 300, chunks[3] - 50, bytes.size() / 2, chunks[1] + 9}) {
      put_bytes(path, bytes.substr(0, cut));
      const std::vector<std::string> read = messages_of(path);
      EXPECT_TRUE(is_prefix(read, all));
      if (compression == Compression::none) {
        const std::size_t headers = count_of(bytes.substr(0, cut), message_op);
        EXPECT_LE(read.size(), headers);
        EXPECT_GE(read.size() + 1, headers);
      } else {
        // All chunks but the one that was cut.
        const auto whole =
            std::count_if(chunks.begin(), chunks.end(), [&](std::size_t at) { return at < cut; }) - 1;
        EXPECT_GE(read.size() * chunks.size(), static_cast<std::size_t>(whole) * all.size() * 9 / 10);
        EXPECT_EQ(read.empty(), whole == 0);
      }
    }
  }
}

TEST_F(BadInput, PieceMissingFromTheMiddleLosesAtMostTheChunksItTouched) {
  const std::string path = bag(Compression::lz4);
  const std::vector<std::string> all = messages_of(path);
  const std::string bytes = bytes_of(path);
  const std::vector<std::size_t> chunks = places_of(bytes, chunk_op);
  put_bytes(path, bytes.substr(0, chunks[1] + 500) + bytes.substr(chunks[1] + 900));
  ScanSummary summary;
  const std::vector<std::string> read = messages_of(path, &summary);
  EXPECT_TRUE(is_subsequence(read, all));
  EXPECT_GE(summary.lost_chunks, 1u);
  EXPECT_LE(summary.lost_chunks, 1u);
  EXPECT_GE(read.size() * chunks.size(), all.size() * (chunks.size() - 1) * 9 / 10);
}

// 3. Empty file, text file, another version, no file.

TEST_F(BadInput, WhatIsNoBagIsSaidSoInOneLine) {
  const std::string path = scratch_ / "a.bag";
  put_bytes(path, "");
  EXPECT_THAT(message_of([&] { read_recording(path); }), AllOf(HasSubstr("a.bag"), HasSubstr("empty")));
  put_bytes(path, "hello, this is a text file\n");
  EXPECT_THAT(message_of([&] { read_recording(path); }),
              AllOf(HasSubstr("is no bag"), HasSubstr("hello, this"), Not(HasSubstr("\n"))));
  put_bytes(path, "#ROSBAG V1.2\nabc");
  EXPECT_THAT(message_of([&] { read_recording(path); }),
              AllOf(HasSubstr("format 1.2"), Not(HasSubstr("\n"))));
  put_bytes(path, "#ROS");
  EXPECT_THAT(message_of([&] { read_recording(path); }), HasSubstr("is no bag"));
  put_bytes(path, "#ROSBAG V2.0\n");
  EXPECT_FALSE(check_bag(path).fit());
  EXPECT_THAT(message_of([&] { salvage_bag(path); }), HasSubstr("nothing is salvaged"));
  EXPECT_FALSE(std::filesystem::exists(salvaged_name(path)));
  EXPECT_THAT(message_of([&] { read_recording(scratch_ / "none.bag"); }),
              HasSubstr("none.bag: cannot be opened"));
  EXPECT_THAT(message_of([&] { read_recording(scratch_.path()); }), HasSubstr("is not a file"));
}

// 4. A corrupt length.

TEST_F(BadInput, CorruptLengthsCostLittleMemoryAndOnlyTheirRecord) {
  constexpr std::size_t memory = 48 << 20;
  for (const Compression compression : all_compressions) {
    const std::string path = bag(compression);
    const std::vector<std::string> all = messages_of(path);
    const std::string bytes = bytes_of(path);
    const std::vector<std::size_t> chunks = places_of(bytes, chunk_op);
    // The bag header's length: nothing but the place of the index is lost.
    std::string bad = bytes;
    bad.replace(13, 4, "\xff\xff\xff\xff");
    put_bytes(path, bad);
    EXPECT_EQ(in_little_memory(memory, [&] { read_recording(path); }), "no error");
    EXPECT_EQ(messages_of(path), all);
    // A chunk's header length, and its data length (after the last field, size).
    const auto size_field = bytes.find("size=", chunks[1]) + 9;
    const auto header = bytes.rfind("compression=", chunks[1]) - 8;
    for (const std::size_t at : {header, size_field}) {
      bad = bytes;
      bad.replace(at, 4, "\xff\xff\xff\x7f");
      put_bytes(path, bad);
      EXPECT_EQ(in_little_memory(memory, [&] { read_recording(path); }), "no error");
      const std::vector<std::string> read = messages_of(path);
      EXPECT_TRUE(is_subsequence(read, all));
      EXPECT_GE(read.size() * chunks.size(), all.size() * (chunks.size() - 1) * 9 / 10);
      if (at == size_field) {
        EXPECT_EQ(read.size(), all.size());
      }
    }
    // The uncompressed size that a chunk claims.
    bad = bytes;
    bad.replace(size_field - 4, 4, "\xff\xff\xff\xff");
    put_bytes(path, bad);
    EXPECT_EQ(in_little_memory(memory, [&] { read_recording(path); }), "no error");
    EXPECT_EQ(messages_of(path), all);
  }
}

TEST_F(BadInput, CorruptMessageLengthInAnUncompressedChunkLosesThatMessage) {
  const std::string path = bag(Compression::none);
  const std::vector<std::string> all = messages_of(path);
  const std::string bytes = bytes_of(path);
  const std::vector<std::size_t> messages = places_of(bytes, message_op);
  const std::size_t length = messages[500] + 8 + 4 + 13;  // after op and time
  for (const std::string& value :
       {std::string("\xff\xff\xff\xff"), std::string("\0\x10\0\0", 4), std::string("\0\0\0\0", 4)}) {
    std::string bad = bytes;
    bad.replace(length, 4, value);
    put_bytes(path, bad);
    EXPECT_EQ(in_little_memory(32 << 20, [&] { read_recording(path); }), "no error");
    const std::vector<std::string> read = messages_of(path);
    // A length of 0 makes an empty message of it.
    const bool is_empty = value == std::string("\0\0\0\0", 4);
    EXPECT_EQ(read.size(), is_empty ? all.size() : all.size() - 1);
    EXPECT_EQ(is_subsequence(read, all), !is_empty);
    EXPECT_TRUE(has(check_bag(path), Severity::error, "damage", ""));
  }
}

TEST_F(BadInput, LengthsInsideAMessageAreNotTrusted) {
  const std::string path = scratch_ / "a.bag";
  {
    BagFile file(path, path, Compression::lz4);
    const std::uint32_t joints =
        file.add_connection(joints_topic, {{"type", "sensor_msgs/JointState"},
                                           {"md5sum", "3066dcd76a6cfaef579bd0f34173e9fd"},
                                           {"message_definition", ""}});
    std::string message(12, '\1');
    message += std::string("\0\0\0\0\xff\xff\xff\x7f", 8);  // frame of length 0, then 2^31 joint names
    file.write(joints, 1000000000, reinterpret_cast<const std::uint8_t*>(message.data()), message.size());
    file.close();
  }
  EXPECT_EQ(in_little_memory(32 << 20, [&] { read_recording(path); }), "no error");
  EXPECT_TRUE(has(check_bag(path), Severity::error, "malformed", joints_topic));
}

// 5. A flipped bit.

TEST_F(BadInput, FlippedBitInACompressedChunkLosesThatChunkAndNothingElse) {
  for (const Compression compression : {Compression::bz2, Compression::lz4}) {
    const std::string path = bag(compression);
    const std::vector<std::string> all = messages_of(path);
    const std::string bytes = bytes_of(path);
    const std::vector<std::size_t> chunks = places_of(bytes, chunk_op);
    std::string bad = bytes;
    bad[chunks[1] + 2000] = static_cast<char>(bad[chunks[1] + 2000] ^ 0x10);
    put_bytes(path, bad);
    ScanSummary summary;
    const std::vector<std::string> read = messages_of(path, &summary);
    EXPECT_EQ(summary.lost_chunks, 1u);
    EXPECT_TRUE(is_subsequence(read, all));
    EXPECT_GE(read.size() * chunks.size(), all.size() * (chunks.size() - 1) * 9 / 10);
    EXPECT_TRUE(has(check_bag(path), Severity::error, "damage", ""));
  }
}

TEST_F(BadInput, FirstChunkLostDoesNotCostTheOthersTheirTypes) {
  const std::string path = bag(Compression::lz4);
  std::string bytes = bytes_of(path);
  const std::vector<std::size_t> chunks = places_of(bytes, chunk_op);
  bytes[chunks[0] + 2000] = static_cast<char>(bytes[chunks[0] + 2000] ^ 0x10);
  put_bytes(path, bytes.substr(0, bytes.size() - 200));
  ScanSummary summary;
  const std::vector<std::string> read = messages_of(path, &summary);
  EXPECT_EQ(summary.orphans, 0u);
  EXPECT_FALSE(read.empty());
}

TEST_F(BadInput, BagWithoutChecksumsIsNamed) {
  EXPECT_TRUE(has(check_bag(bag(Compression::none)), Severity::warning, "no_checksum", ""));
}

TEST_F(BadInput, WhateverIsDamagedNothingIsInvented) {
  Random random(7);
  for (const Compression compression : {Compression::bz2, Compression::lz4}) {
    const std::string path = bag(compression, 20.0);
    const std::vector<std::string> all = messages_of(path);
    const std::string bytes = bytes_of(path);
    for (int trial = 0; trial < 60; ++trial) {
      std::string bad = bytes;
      const auto place = [&] {
        return static_cast<std::size_t>(random.uniform() * static_cast<double>(bad.size()));
      };
      for (int flips = 0; flips < 3; ++flips) bad[place()] = static_cast<char>(random.bits());
      if (trial % 3 == 0) bad.erase(place(), 100);
      if (trial % 3 == 1) bad.insert(place(), std::string(50, static_cast<char>(random.bits())));
      put_bytes(path, "#ROSBAG V2.0\n" + bad.substr(13));
      std::vector<std::string> read = messages_of(path);
      // A damaged chunk length may make the scan find a chunk a second time; the messages stay what they
      // were.
      EXPECT_TRUE(is_subsequence(read, all)) << trial;
    }
  }
}

// 6. Another md5, an unknown type.

TEST_F(BadInput, TopicOfAnotherTypeIsRefusedByName) {
  const std::string path = scratch_ / "a.bag";
  {
    rosbag::Bag file(path, rosbag::bagmode::Write);
    file.write(displacement_topic, ros::Time(1000), std_msgs::Float64());
    file.write("/somewhere/else", ros::Time(1000), std_msgs::Float64());
    sensor_msgs::Temperature temperature;
    temperature.header.stamp = ros::Time(1000);
    file.write(temperature_topic, ros::Time(1000), temperature);
  }
  const Recording recording = read_recording(path);
  EXPECT_TRUE(recording.log.draw_wire.time.empty());
  EXPECT_EQ(recording.log.temperature.time.size(), 1u);
  EXPECT_EQ(recording.other_topics.at("/somewhere/else"), 1u);
  EXPECT_THAT(message_of([&] { read_run_log(path); }),
              AllOf(HasSubstr("a.bag"), HasSubstr(displacement_topic), HasSubstr("std_msgs/Float64")));
  EXPECT_TRUE(has(check_bag(path), Severity::error, "type", displacement_topic));
}

TEST_F(BadInput, TopicOfAnotherVersionOfItsTypeIsRefusedByName) {
  const std::string path = scratch_ / "a.bag";
  {
    BagFile file(path, path, Compression::lz4);
    const std::uint32_t wrench =
        file.add_connection(wrench_topic, {{"type", "geometry_msgs/WrenchStamped"},
                                           {"md5sum", "0123456789abcdef0123456789abcdef"},
                                           {"message_definition", "float64 x\n"}});
    const std::string message(8, '\0');
    file.write(wrench, 1000000000, reinterpret_cast<const std::uint8_t*>(message.data()), message.size());
    file.close();
  }
  EXPECT_THAT(message_of([&] { read_run_log(path); }),
              AllOf(HasSubstr(wrench_topic), HasSubstr("0123456789abcdef")));
}

// 7. NaN and infinities. 8. Stamps backward and twice. 9. Time 0.

TEST_F(BadInput, NaNAndInfinityAreReportedAndDropped) {
  run_log::RunLog log = sound_run();
  log.ft.force[300].z() = std::numeric_limits<double>::quiet_NaN();
  log.ft.torque[301].x() = std::numeric_limits<double>::infinity();
  log.draw_wire.value[5] = -std::numeric_limits<double>::infinity();
  write_bag(log, scratch_ / "a.bag");
  const CheckReport report = check_bag(scratch_ / "a.bag");
  EXPECT_TRUE(report.fit());
  ASSERT_EQ(report.findings.size(), 2u);
  EXPECT_EQ(report.findings[0].kind, "not_finite");
  EXPECT_EQ(report.findings[0].count, 2u);
  EXPECT_EQ(report.findings[0].first_time, log.ft.time[300]);
  EXPECT_EQ(read_run_log(scratch_ / "a.bag").ft.time.size(), log.ft.time.size() - 2);
  for (std::size_t i = 0; i < 100; ++i) log.ft.force[i].x() = std::numeric_limits<double>::quiet_NaN();
  write_bag(log, scratch_ / "b.bag");
  EXPECT_TRUE(has(check_bag(scratch_ / "b.bag"), Severity::error, "not_finite", wrench_topic));
}

TEST_F(BadInput, StampsBackwardAndTwiceAreReportedAndSorted) {
  run_log::RunLog log = sound_run();
  std::swap(log.ft.time[500], log.ft.time[501]);
  log.draw_wire.time[700] = log.draw_wire.time[699];
  // As recorded: the writer orders by stamp, a recorder by arrival.
  {
    BagWriter writer(scratch_ / "a.bag", log.epoch);
    for (std::size_t i = 0; i < log.ft.time.size(); ++i) {
      writer.wrench(log.ft.time[i], log.ft.force[i], log.ft.torque[i]);
      writer.displacement(log.draw_wire.time[i], log.draw_wire.value[i]);
      writer.joints(log.joints.time[i],
                    {log.joints.carriage_position[i], log.joints.carriage_velocity[i],
                     log.joints.wheel_angle[i], log.joints.wheel_rate[i], log.joints.wheel_effort[i]});
    }
    writer.close();
  }
  CheckReport report = check_bag(scratch_ / "a.bag");
  EXPECT_TRUE(has(report, Severity::warning, "backward", wrench_topic));
  EXPECT_TRUE(has(report, Severity::warning, "repeated", displacement_topic));
  EXPECT_TRUE(report.fit()) << to_text(report);
  const run_log::RunLog read = read_run_log(scratch_ / "a.bag");
  EXPECT_TRUE(std::is_sorted(read.ft.time.begin(), read.ft.time.end()));
  EXPECT_EQ(read.ft.time.size(), log.ft.time.size());
  EXPECT_EQ(read.draw_wire.time.size(), log.draw_wire.time.size() - 1);
  // A clock set back by 2 s in the middle of the run.
  {
    BagWriter writer(scratch_ / "b.bag", log.epoch);
    for (std::size_t i = 0; i < log.ft.time.size(); ++i)
      writer.wrench(0.02 * static_cast<double>(i) - (i > 600 ? 2.0 : 0.0), log.ft.force[i], log.ft.torque[i]);
    writer.close();
  }
  EXPECT_TRUE(has(check_bag(scratch_ / "b.bag"), Severity::error, "backward", wrench_topic));
}

TEST_F(BadInput, TimeZeroIsReportedAndSalvagedWithATime) {
  const std::string path = scratch_ / "a.bag";
  {
    BagFile file(path, path, Compression::lz4);
    const std::uint32_t id = file.add_connection(
        displacement_topic,
        {{"type", "wheel_twin/DisplacementStamped"},
         {"md5sum", ros::message_traits::MD5Sum<DisplacementStamped>::value()},
         {"message_definition", ros::message_traits::Definition<DisplacementStamped>::value()}});
    std::vector<std::uint8_t> bytes;
    const auto append = [&](ros::Time stamp, std::uint64_t bag_time) {
      DisplacementStamped message;
      message.header.stamp = stamp;
      bytes.resize(ros::serialization::serializationLength(message));
      ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
      ros::serialization::serialize(stream, message);
      file.write(id, bag_time, bytes.data(), bytes.size());
    };
    append(ros::Time(1000), 1000000000000);
    append(ros::Time(0), 1001000000000);
    append(ros::Time(1002), 0);
    file.close();
  }
  const Recording recording = read_recording(path);
  EXPECT_EQ(recording.log.draw_wire.time.size(), 2u);
  EXPECT_TRUE(has(check_bag(path), Severity::warning, "time_zero", displacement_topic));
  const Salvage salvage = salvage_bag(path);
  EXPECT_EQ(salvage.time_zero, 1u);
  EXPECT_EQ(messages_of(salvage.output).size(), 3u);
  rosbag::Bag reread(salvage.output);
  EXPECT_EQ(reread.getSize(), std::filesystem::file_size(salvage.output));
}

// 10. YAML: experiment_test.cpp and base/yaml_test.cpp.

// Salvage itself.

TEST_F(BadInput, IntactBagIsLeftAlone) {
  const std::string path = bag(Compression::lz4);
  EXPECT_EQ(salvage_bag(path).output, "");
  EXPECT_FALSE(std::filesystem::exists(salvaged_name(path)));
}

TEST_F(BadInput, SalvageDoesNotOverwrite) {
  const std::string path = bag(Compression::lz4);
  const std::string bytes = bytes_of(path);
  put_bytes(path, bytes.substr(0, bytes.size() - 200));
  put_bytes(scratch_ / "run.salvaged.bag", "mine");
  EXPECT_THAT(message_of([&] { salvage_bag(path); }), HasSubstr("exists already"));
  EXPECT_EQ(bytes_of(scratch_ / "run.salvaged.bag"), "mine");
}

TEST_F(BadInput, FullDiskIsAnErrorAndLeavesNothingBehind) {
  const std::string path = scratch_ / "full.bag";
  const std::string said = in_little_memory(256 << 20, [&] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit small{100000, 100000};
    setrlimit(RLIMIT_FSIZE, &small);
    write_bag(sound_run(60.0), path);
  });
  EXPECT_THAT(said, AllOf(HasSubstr("full.bag"), HasSubstr("cannot be written")));
  EXPECT_TRUE(std::filesystem::is_empty(scratch_.path()));
}

}  // namespace
}  // namespace wheel_twin::logs
