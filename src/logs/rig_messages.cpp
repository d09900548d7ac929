#include "logs/rig_messages.h"

#include <cstring>

namespace wheel_twin::logs {
namespace {

/// Reads forward; once it runs out, everything is 0 and complete() is false.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  template <typename T>
  T take() {
    T value{};
    if (left_ < sizeof(T)) {
      short_ = true;
      left_ = 0;
      return value;
    }
    std::memcpy(&value, data_, sizeof(T));
    data_ += sizeof(T);
    left_ -= sizeof(T);
    return value;
  }

  std::string text() {
    const auto length = take<std::uint32_t>();
    if (length > left_) {
      short_ = true;
      left_ = 0;
      return {};
    }
    std::string value(reinterpret_cast<const char*>(data_), length);
    data_ += length;
    left_ -= length;
    return value;
  }

  /// Length of an array whose elements have at least `element` bytes.
  std::size_t count(std::size_t element) {
    const auto length = take<std::uint32_t>();
    if (length > left_ / element) short_ = true;
    return short_ ? 0 : length;
  }

  std::uint64_t header() {
    take<std::uint32_t>();  // sequence number
    const auto seconds = take<std::uint32_t>();
    const auto nanoseconds = take<std::uint32_t>();
    text();  // frame
    return seconds * 1000000000ULL + nanoseconds;
  }

  Eigen::Vector3d vector() {
    const auto x = take<double>();
    const auto y = take<double>();
    const auto z = take<double>();
    return {x, y, z};
  }

  void numbers(std::vector<double>& values) {
    values.resize(count(sizeof(double)));
    for (double& value : values) value = take<double>();
  }

  bool complete() const { return !short_ && left_ == 0; }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
  bool short_ = false;
};

}  // namespace

bool parse_wrench(const std::uint8_t* data, std::size_t size, WrenchMessage& message) {
  Bytes bytes(data, size);
  message.stamp = bytes.header();
  message.force = bytes.vector();
  message.torque = bytes.vector();
  return bytes.complete();
}

bool parse_displacement(const std::uint8_t* data, std::size_t size, ScalarMessage& message) {
  Bytes bytes(data, size);
  message.stamp = bytes.header();
  message.value = bytes.take<double>();
  return bytes.complete();
}

bool parse_temperature(const std::uint8_t* data, std::size_t size, ScalarMessage& message) {
  Bytes bytes(data, size);
  message.stamp = bytes.header();
  message.value = bytes.take<double>();
  bytes.take<double>();  // variance
  return bytes.complete();
}

bool parse_joints(const std::uint8_t* data, std::size_t size, JointMessage& message) {
  Bytes bytes(data, size);
  message.stamp = bytes.header();
  message.names.resize(bytes.count(sizeof(std::uint32_t)));
  for (std::string& name : message.names) name = bytes.text();
  bytes.numbers(message.position);
  bytes.numbers(message.velocity);
  bytes.numbers(message.effort);
  return bytes.complete();
}

}  // namespace wheel_twin::logs
