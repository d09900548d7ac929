#include "logs/message_definition.h"

#include <gtest/gtest.h>

#include <cstring>

#include "base/error.h"

namespace wheel_twin::logs {
namespace {

const char definition[] =
    "Header header # stamp and frame\n"
    "uint8 CONSTANT=7\n"
    "Part[] parts\n"
    "float32[3] fixed\n"
    "string note\n"
    "Part last\n"
    "================================================================================\n"
    "MSG: std_msgs/Header\n"
    "uint32 seq\ntime stamp\nstring frame_id\n"
    "================================================================================\n"
    "MSG: foreign_msgs/Part\n"
    "bool on\nfloat64 value\n";

class Bytes {
 public:
  template <typename T>
  Bytes& add(T value) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    data.insert(data.end(), bytes, bytes + sizeof value);
    return *this;
  }
  Bytes& text(const std::string& value) {
    add(static_cast<std::uint32_t>(value.size()));
    data.insert(data.end(), value.begin(), value.end());
    return *this;
  }
  std::vector<std::uint8_t> data;
};

Bytes message() {
  Bytes bytes;
  bytes.add<std::uint32_t>(3).add<std::uint32_t>(1600000000).add<std::uint32_t>(250000000).text("sensor");
  bytes.add<std::uint32_t>(2);  // parts
  for (const double value : {1.0, 2.0}) bytes.add<std::uint8_t>(1).add(value);
  bytes.add(0.5F).add(0.25F).add(0.125F).text("any length");
  bytes.add<std::uint8_t>(1).add(-42.5);
  return bytes;
}

TEST(MessageDefinition, ReadsFieldsBehindTextsArraysAndConstants) {
  const MessageDefinition reader("foreign_msgs/Thing", definition,
                                 {"last.value", "header.stamp.secs", "header.stamp.nsecs", "last.on"});
  const Bytes bytes = message();
  EXPECT_EQ(reader.read(bytes.data.data(), bytes.data.size()),
            (std::vector<double>{-42.5, 1600000000.0, 250000000.0, 1.0}));
}

TEST(MessageDefinition, RefusesAMessageOfAnotherLength) {
  const MessageDefinition reader("foreign_msgs/Thing", definition, {"last.value"});
  Bytes bytes = message();
  EXPECT_THROW(reader.read(bytes.data.data(), bytes.data.size() - 1), Error);
  bytes.add<std::uint8_t>(0);
  EXPECT_THROW(reader.read(bytes.data.data(), bytes.data.size()), Error);
}

TEST(MessageDefinition, AHugeLengthIsNoHugeWalk) {
  const MessageDefinition reader("foreign_msgs/Thing", definition, {"last.value"});
  Bytes bytes;
  bytes.add<std::uint32_t>(3).add<std::uint32_t>(1).add<std::uint32_t>(0).add<std::uint32_t>(0xffffffffU);
  EXPECT_THROW(reader.read(bytes.data.data(), bytes.data.size()), Error);
}

TEST(MessageDefinition, NamesWhatTheMessageLacks) {
  EXPECT_THROW(MessageDefinition("foreign_msgs/Thing", definition, {"last.colour"}), Error);
  EXPECT_THROW(MessageDefinition("foreign_msgs/Thing", definition, {"note"}), Error);
  EXPECT_THROW(MessageDefinition("foreign_msgs/Thing", "Missing part\n", {}), Error);
}

}  // namespace
}  // namespace wheel_twin::logs
