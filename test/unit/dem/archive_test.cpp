#include "dem/archive.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <future>
#include <limits>

#include "base/error.h"
#include "dem/cache.h"

namespace wheel_twin::dem {
namespace {

class ArchiveTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("archive_test_" + std::to_string(getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  static Archive sample(double value) {
    Archive archive;
    archive.set("position", std::vector<double>{0.1, -0.0, 1e-310, value, 5.0, 6.0}, 3);
    archive.set("force", std::vector<float>{1.5F, std::numeric_limits<float>::min()});
    archive.set("shape", std::vector<std::int32_t>{-1, 2});
    archive.set("key", std::vector<std::uint64_t>{~0ULL});
    archive.set("empty", std::vector<std::int64_t>{});
    archive.set_number("time", value);
    archive.set_text("soil", "four_sphere");
    archive.set_text("nothing", "");
    return archive;
  }

  std::string message_of(const std::string& path, const std::string& kind) const {
    try {
      read_archive(path, kind);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

TEST_F(ArchiveTest, ComesThroughAMessageBitByBit) {
  const Archive sent = sample(1.0 / 3.0);
  const std::vector<std::uint8_t> bytes = archive_bytes("bed", sent);
  EXPECT_EQ(archive_from_bytes(bytes, "bed", "message").hash(), sent.hash());
  EXPECT_THROW(archive_from_bytes(bytes, "checkpoint", "message"), Error);
  EXPECT_THROW(archive_from_bytes({bytes.begin(), bytes.begin() + bytes.size() / 2}, "bed", "message"),
               Error);
  EXPECT_THROW(archive_from_bytes({}, "bed", "message"), Error);
}

TEST_F(ArchiveTest, ComesBackBitByBit) {
  const Archive written = sample(1.0 / 3.0);
  write_archive(file("a.h5"), "bed", written);
  const Archive read = read_archive(file("a.h5"), "bed");
  EXPECT_EQ(read.hash(), written.hash());
  EXPECT_EQ(read.get<double>("position"), written.get<double>("position"));
  EXPECT_TRUE(std::signbit(read.get<double>("position")[1]));
  EXPECT_EQ(read.get<std::uint64_t>("key")[0], ~0ULL);
  EXPECT_EQ(read.number("time"), 1.0 / 3.0);
  EXPECT_EQ(read.text("soil"), "four_sphere");
  EXPECT_EQ(read.arrays().at("position").columns, 3U);
}

TEST_F(ArchiveTest, HashSeesEveryPart) {
  const std::string hash = sample(1.0).hash();
  EXPECT_EQ(sample(1.0).hash(), hash);
  EXPECT_NE(sample(std::nextafter(1.0, 2.0)).hash(), hash);
  Archive text = sample(1.0);
  text.set_text("soil", "two_sphere");
  EXPECT_NE(text.hash(), hash);
  Archive shape = sample(1.0);
  shape.set("position", sample(1.0).get<double>("position"), 2);
  EXPECT_NE(shape.hash(), hash);
}

TEST_F(ArchiveTest, RefusesWithOneLineThatNamesTheFile) {
  write_archive(file("bed.h5"), "bed", sample(1.0));
  EXPECT_NE(message_of(file("bed.h5"), "checkpoint").find("holds a bed, a checkpoint is expected"),
            std::string::npos);
  EXPECT_NE(message_of(file("none.h5"), "bed").find("none.h5: does not exist"), std::string::npos);
  std::ofstream(file("text.h5")) << "not a bed\n";
  EXPECT_NE(message_of(file("text.h5"), "bed").find("not an HDF5 file"), std::string::npos);
  const Archive read = read_archive(file("bed.h5"), "bed");
  EXPECT_THROW(read.get<double>("missing"), Error);
  EXPECT_THROW(read.get<float>("position"), Error);
}

TEST_F(ArchiveTest, RefusesEveryTruncation) {
  write_archive(file("bed.h5"), "bed", sample(1.0));
  const auto size = std::filesystem::file_size(file("bed.h5"));
  for (std::uintmax_t cut = 0; cut < size; cut += 97) {
    std::filesystem::copy_file(file("bed.h5"), file("cut.h5"),
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(file("cut.h5"), cut);
    EXPECT_NE(message_of(file("cut.h5"), "bed"), "") << "cut to " << cut << " of " << size;
  }
}

TEST_F(ArchiveTest, ADamagedNumberIsFound) {
  Archive archive;
  archive.set("position", std::vector<double>(1000, 0.123456789));
  write_archive(file("bed.h5"), "bed", archive);
  std::string bytes;
  {
    std::ifstream in(file("bed.h5"), std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  const double value = 0.123456789;
  const std::size_t place =
      bytes.find(std::string(reinterpret_cast<const char*>(&value), sizeof value), 2000);
  ASSERT_NE(place, std::string::npos);
  bytes[place + 3] ^= 1;
  std::ofstream(file("bed.h5"), std::ios::binary) << bytes;
  EXPECT_NE(message_of(file("bed.h5"), "bed").find("damaged"), std::string::npos);
}

// A process that writes checkpoints without end is killed at many moments; a good checkpoint is there every
// time.
TEST_F(ArchiveTest, KilledWriterLeavesAGoodFile) {
  write_archive(file("state.h5"), "checkpoint", sample(0.0));
  for (int trial = 0; trial < 20; ++trial) {
    int started[2];
    ASSERT_EQ(pipe(started), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      Archive archive = sample(1.0);
      archive.set("large", std::vector<double>(20000, 1.0));
      for (int step = 1;; ++step) {
        archive.set_number("time", step);
        if (write(started[1], "x", 1) != 1) _exit(1);
        write_archive(file("state.h5"), "checkpoint", archive);
      }
    }
    // Kill somewhere inside the write that begins after `trial % 4` whole ones.
    char byte = 0;
    for (int i = 0; i <= trial % 4; ++i) ASSERT_EQ(read(started[0], &byte, 1), 1);
    for (volatile int spin = 0; spin < trial * 20000; ++spin) {
    }
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(started[0]);
    close(started[1]);
    EXPECT_EQ(message_of(file("state.h5"), "checkpoint"), "");
  }
}

TEST(Sha256, PublishedVector) {  // FIPS 180-4 example "abc"
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

// The second asks while the first is at work, or comes after it: it gets what the first has made.
TEST_F(ArchiveTest, OfTwoThatWantTheSameFileOneMakesIt) {
  ASSERT_EQ(setenv("WHEEL_TWIN_CACHE", folder_.c_str(), 1), 0);
  std::future<Archive> second;
  const Archive first = fetch("thing", "the same", [&] {
    second = std::async(std::launch::async, [] {
      return fetch("thing", "the same", []() -> Archive { throw Error("made twice"); });
    });
    return sample(2.5);
  });
  EXPECT_EQ(second.get().get<double>("position"), first.get<double>("position"));
  // Nothing but the file stays behind.
  const auto left =
      std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator());
  EXPECT_EQ(left, 1);
  // A maker that fails leaves the way free.
  EXPECT_THROW(fetch("thing", "other", []() -> Archive { throw Error("no"); }), Error);
  EXPECT_EQ(fetch("thing", "other", [] { return sample(1.0); }).number("time"), 1.0);
  unsetenv("WHEEL_TWIN_CACHE");
}

}  // namespace
}  // namespace wheel_twin::dem
