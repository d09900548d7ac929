#include "logs/bag_writer.h"

#include <fmt/format.h>
#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Temperature.h>
#include <wheel_twin/DisplacementStamped.h>

#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <system_error>
#include <utility>

#include "base/atomic_file.h"
#include "base/error.h"
#include "logs/bag_file.h"
#include "logs/stamp.h"
#include "logs/topics.h"

namespace wheel_twin::logs {
namespace {

/// The messages of a rig log, kept from one sample to the next to save their allocations.
class RigBag {
 public:
  RigBag(const std::string& file, std::string name, double epoch, Compression compression)
      : name_(std::move(name)), epoch_(epoch), bag_(file, name_, compression) {
    wrench_.header.frame_id = "ft_sensor";
    displacement_.header.frame_id = "rig";
    joints_.header.frame_id = "rig";
    joints_.name = {"carriage", "wheel"};
    joints_.position.resize(2);
    joints_.velocity.resize(2);
    temperature_.header.frame_id = "rig";
  }

  void wrench(double time, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
    wrench_.wrench.force.x = force.x();
    wrench_.wrench.force.y = force.y();
    wrench_.wrench.force.z = force.z();
    wrench_.wrench.torque.x = torque.x();
    wrench_.wrench.torque.y = torque.y();
    wrench_.wrench.torque.z = torque.z();
    write(wrench_topic, time, wrench_);
  }

  void displacement(double time, double value) {
    displacement_.displacement = value;
    write(displacement_topic, time, displacement_);
  }

  void joints(double time, const BagWriter::Joints& joints, bool has_effort) {
    joints_.position = {joints.carriage_position, joints.wheel_angle};
    joints_.velocity = {joints.carriage_velocity, joints.wheel_rate};
    if (has_effort)
      joints_.effort = {0.0, joints.wheel_effort};
    else
      joints_.effort.clear();
    write(joints_topic, time, joints_);
  }

  void temperature(double time, double celsius) {
    temperature_.temperature = celsius;
    write(temperature_topic, time, temperature_);
  }

  void close() { bag_.close(); }

 private:
  template <typename Message>
  void write(const char* topic, double time, Message& message) {
    const std::int64_t stamp = std::isfinite(time) ? to_nanoseconds(epoch_, time) : 0;
    if (stamp <= 0 || stamp / 1000000000 > std::numeric_limits<std::uint32_t>::max())
      throw Error(
          fmt::format("{}: {}: the time {} s after epoch {} s is no ROS time", name_, topic, time, epoch_));
    message.header.stamp.sec = static_cast<std::uint32_t>(stamp / 1000000000);
    message.header.stamp.nsec = static_cast<std::uint32_t>(stamp % 1000000000);
    bytes_.resize(ros::serialization::serializationLength(message));
    ros::serialization::OStream stream(bytes_.data(), static_cast<std::uint32_t>(bytes_.size()));
    ros::serialization::serialize(stream, message);
    bag_.write(connection<Message>(topic), static_cast<std::uint64_t>(stamp), bytes_.data(), bytes_.size());
    ++message.header.seq;
  }

  /// Each topic has one type here.
  template <typename Message>
  std::uint32_t connection(const char* topic) {
    const auto known = connections_.find(topic);
    if (known != connections_.end()) return known->second;
    return connections_[topic] = bag_.add_connection(
               topic, {{"type", ros::message_traits::DataType<Message>::value()},
                       {"md5sum", ros::message_traits::MD5Sum<Message>::value()},
                       {"message_definition", ros::message_traits::Definition<Message>::value()}});
  }

  std::string name_;
  double epoch_;
  BagFile bag_;
  std::map<std::string, std::uint32_t, std::less<>> connections_;
  std::vector<std::uint8_t> bytes_;
  geometry_msgs::WrenchStamped wrench_;
  DisplacementStamped displacement_;
  sensor_msgs::JointState joints_;
  sensor_msgs::Temperature temperature_;
};

void require_columns(const run_log::RunLog& log, const std::string& path) {
  const auto require = [&](const char* topic, std::size_t size, std::size_t expected) {
    if (size != expected)
      throw Error(fmt::format("{}: {}: a column has {} values for {} stamps", path, topic, size, expected));
  };
  require(wrench_topic, log.ft.force.size(), log.ft.time.size());
  require(wrench_topic, log.ft.torque.size(), log.ft.time.size());
  require(displacement_topic, log.draw_wire.value.size(), log.draw_wire.time.size());
  const auto& joints = log.joints;
  for (const auto* column :
       {&joints.carriage_position, &joints.carriage_velocity, &joints.wheel_angle, &joints.wheel_rate})
    require(joints_topic, column->size(), joints.time.size());
  if (!joints.wheel_effort.empty()) require(joints_topic, joints.wheel_effort.size(), joints.time.size());
  require(temperature_topic, log.temperature.value.size(), log.temperature.time.size());
}

}  // namespace

void write_bag(const run_log::RunLog& log, const std::string& path, Compression compression) {
  require_columns(log, path);
  AtomicFile file(path);
  RigBag bag(file.path(), path, log.epoch, compression);
  const auto& joints = log.joints;
  const bool has_effort = !joints.wheel_effort.empty();
  const std::array<const std::vector<double>*, 4> times{&log.ft.time, &log.draw_wire.time, &joints.time,
                                                        &log.temperature.time};
  std::array<std::size_t, 4> next{};
  for (;;) {
    std::size_t series = times.size();
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (next[i] == times[i]->size()) continue;
      if (series == times.size() || (*times[i])[next[i]] < (*times[series])[next[series]]) series = i;
    }
    if (series == times.size()) break;
    const std::size_t k = next[series]++;
    const double time = (*times[series])[k];
    if (series == 0)
      bag.wrench(time, log.ft.force[k], log.ft.torque[k]);
    else if (series == 1)
      bag.displacement(time, log.draw_wire.value[k]);
    else if (series == 2)
      bag.joints(time,
                 {joints.carriage_position[k], joints.carriage_velocity[k], joints.wheel_angle[k],
                  joints.wheel_rate[k], has_effort ? joints.wheel_effort[k] : 0.0},
                 has_effort);
    else
      bag.temperature(time, log.temperature.value[k]);
  }
  bag.close();
  file.commit();
}

class BagWriter::Impl {
 public:
  Impl(std::string path, double epoch, Compression compression)
      : path_(std::move(path)), active_(path_ + ".active"), bag_(active_, path_, epoch, compression) {}

  RigBag& bag() {
    if (closed_) throw Error(fmt::format("{}: is closed and takes no more messages", path_));
    return bag_;
  }

  void close() {
    if (closed_) return;
    bag_.close();
    closed_ = true;
    std::error_code code;
    std::filesystem::rename(active_, path_, code);
    if (code) throw Error(fmt::format("{}: cannot be written: {}", path_, code.message()));
  }

 private:
  std::string path_;
  std::string active_;
  RigBag bag_;
  bool closed_ = false;
};

BagWriter::BagWriter(std::string path, double epoch, Compression compression)
    : impl_(std::make_unique<Impl>(std::move(path), epoch, compression)) {}
BagWriter::~BagWriter() = default;

void BagWriter::wrench(double time, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  impl_->bag().wrench(time, force, torque);
}
void BagWriter::displacement(double time, double value) {
  impl_->bag().displacement(time, value);
}
void BagWriter::joints(double time, const Joints& joints) {
  impl_->bag().joints(time, joints, true);
}
void BagWriter::temperature(double time, double celsius) {
  impl_->bag().temperature(time, celsius);
}
void BagWriter::close() {
  impl_->close();
}

}  // namespace wheel_twin::logs
