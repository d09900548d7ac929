#include "logs/cmu_testbed_bag.h"

#include <fmt/format.h>
#include <ros/serialization.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <cmath>

#include "base/error.h"
#include "logs/message_definition.h"

namespace wheel_twin::logs::cmu {
namespace {

const char reading_type[] = "rokubimini_msgs/Reading";

const std::vector<std::string>& reading_fields() {
  static const std::vector<std::string> fields = {"header.stamp.secs",
                                                  "header.stamp.nsecs",
                                                  "wrench.wrench.force.x",
                                                  "wrench.wrench.force.y",
                                                  "wrench.wrench.force.z",
                                                  "wrench.wrench.torque.x",
                                                  "wrench.wrench.torque.y",
                                                  "wrench.wrench.torque.z",
                                                  "imu.linear_acceleration.x",
                                                  "imu.linear_acceleration.y",
                                                  "imu.linear_acceleration.z",
                                                  "isForceTorqueSaturated",
                                                  "temperature"};
  return fields;
}

void append(const std::vector<double>& v, FtRecording& recording) {
  const double time = v[0] + v[1] * 1e-9;
  bool good = recording.time.empty() || time > recording.time.back();
  for (std::size_t i = 2; i < v.size(); ++i) good = good && std::isfinite(v[i]);
  if (!good) {
    ++recording.dropped;
    return;
  }
  recording.time.push_back(time);
  recording.force.emplace_back(v[2], v[3], v[4]);
  recording.torque.emplace_back(v[5], v[6], v[7]);
  recording.acceleration += Eigen::Vector3d(v[8], v[9], v[10]);
  if (v[11] != 0.0) ++recording.saturated;
  recording.temperature.push_back(v[12]);
}

}  // namespace

FtRecording read_ft(const std::string& path) {
  FtRecording recording;
  try {
    rosbag::Bag bag(path, rosbag::bagmode::Read);
    rosbag::View view(bag, rosbag::TypeQuery(reading_type));
    std::vector<std::uint8_t> bytes;
    std::string definition_text;
    std::unique_ptr<MessageDefinition> definition;
    for (const rosbag::MessageInstance& message : view) {
      if (!definition || message.getMessageDefinition() != definition_text) {
        definition_text = message.getMessageDefinition();
        definition = std::make_unique<MessageDefinition>(reading_type, definition_text, reading_fields());
      }
      bytes.resize(message.size());
      ros::serialization::OStream stream(bytes.data(), message.size());
      message.write(stream);
      append(definition->read(bytes.data(), bytes.size()), recording);
    }
  } catch (const rosbag::BagException& error) {
    throw Error(fmt::format("{}: {}", path, error.what()));
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", path, error.what()));
  }
  if (recording.time.empty()) throw Error(fmt::format("{}: holds no message of type {}", path, reading_type));
  recording.acceleration /= static_cast<double>(recording.time.size());
  return recording;
}

Tare tare_of(const FtRecording& recording) {
  Tare tare;
  const auto count = static_cast<double>(recording.time.size());
  for (const auto& force : recording.force) tare.force += force / count;
  for (const auto& torque : recording.torque) tare.torque += torque / count;
  for (const double temperature : recording.temperature) tare.temperature += temperature / count;
  for (const auto& force : recording.force) tare.force_std += (force - tare.force).cwiseAbs2() / count;
  tare.force_std = tare.force_std.cwiseSqrt();
  tare.time = recording.time.front();
  return tare;
}

Eigen::Vector3d to_rig_axes(const Eigen::Vector3d& sensor) {
  return {-sensor.y(), -sensor.x(), -sensor.z()};
}

}  // namespace wheel_twin::logs::cmu
