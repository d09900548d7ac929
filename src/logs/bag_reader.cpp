#include "logs/bag_reader.h"

#include <fmt/format.h>
#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Temperature.h>
#include <wheel_twin/DisplacementStamped.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "base/error.h"
#include "logs/bag_scanner.h"
#include "logs/rig_messages.h"
#include "logs/stamp.h"
#include "logs/topics.h"

namespace wheel_twin::logs {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
// Stamps farther than this from the middle one do not set the epoch: no run lasts a day.
constexpr std::int64_t credible_span = 24LL * 3600 * 1000000000;

struct TopicType {
  const char* topic;
  const char* type;
  const char* md5sum;
};

template <typename Message>
TopicType topic_type(const char* topic) {
  return {topic, ros::message_traits::DataType<Message>::value(),
          ros::message_traits::MD5Sum<Message>::value()};
}

const TopicType* find_topic(const std::string& topic) {
  static const std::array<TopicType, 4> known{topic_type<geometry_msgs::WrenchStamped>(wrench_topic),
                                              topic_type<DisplacementStamped>(displacement_topic),
                                              topic_type<sensor_msgs::JointState>(joints_topic),
                                              topic_type<sensor_msgs::Temperature>(temperature_topic)};
  const auto found =
      std::find_if(known.begin(), known.end(), [&](const TopicType& t) { return topic == t.topic; });
  return found == known.end() ? nullptr : &*found;
}

/// Stamps and arrivals in ns, before the epoch is known.
struct Times {
  std::vector<std::int64_t> stamp;
  std::vector<std::int64_t> arrival;
};

class Reader {
 public:
  Recording read(ByteSource& source, const std::string& name) {
    const ScanSummary summary = scan_bag(source, name, [this](const BagMessage& message) { visit(message); });
    finish(summary);
    return std::move(recording_);
  }

 private:
  Defect& note(Defect::Kind kind, const std::string& topic, std::uint64_t arrival, const std::string& text) {
    for (Defect& defect : recording_.defects)
      if (defect.kind == kind && defect.topic == topic && defect.text == text) {
        ++defect.count;
        return defect;
      }
    recording_.defects.push_back({kind, topic, 1, missing, text});
    first_arrivals_.resize(recording_.defects.size(), static_cast<std::int64_t>(arrival));
    return recording_.defects.back();
  }

  void visit(const BagMessage& message) {
    const std::string& topic = message.connection->topic;
    const TopicType* known = find_topic(topic);
    if (known == nullptr) {
      ++recording_.other_topics[topic];
      return;
    }
    const BagConnection& connection = *message.connection;
    if (connection.md5sum != known->md5sum || connection.type != known->type) {
      note(Defect::Kind::refused, topic, message.time,
           fmt::format("type {:.80} (md5 {:.32}) instead of {} (md5 {}): the topic is not read",
                       connection.type, connection.md5sum, known->type, known->md5sum));
      return;
    }
    bool readable = false;
    if (topic == wrench_topic)
      readable =
          parse_wrench(message.data, message.size, wrench_) && keep(message, topic, wrench_.stamp, ft_);
    else if (topic == displacement_topic)
      readable = parse_displacement(message.data, message.size, scalar_) &&
                 keep(message, topic, scalar_.stamp, draw_wire_);
    else if (topic == joints_topic)
      readable = parse_joints(message.data, message.size, joints_) &&
                 keep(message, topic, joints_.stamp, joint_times_);
    else
      readable = parse_temperature(message.data, message.size, scalar_) &&
                 keep(message, topic, scalar_.stamp, temperature_);
    if (!readable)
      note(Defect::Kind::malformed, topic, message.time,
           fmt::format("a message is no {}: not read", known->type));
  }

  /// Appends the sample that was parsed last. Always true: a stamp of 0 is another matter than an unreadable
  /// message.
  bool keep(const BagMessage& message, const std::string& topic, std::uint64_t stamp, Times& times) {
    if (stamp == 0) {
      note(Defect::Kind::time_zero, topic, message.time,
           "header stamp is time 0: the sample has no time and is not read");
      return true;
    }
    times.stamp.push_back(static_cast<std::int64_t>(stamp));
    times.arrival.push_back(static_cast<std::int64_t>(message.time));
    run_log::RunLog& log = recording_.log;
    if (&times == &ft_) {
      log.ft.force.push_back(wrench_.force);
      log.ft.torque.push_back(wrench_.torque);
    } else if (&times == &draw_wire_) {
      log.draw_wire.value.push_back(scalar_.value);
    } else if (&times == &temperature_) {
      log.temperature.value.push_back(scalar_.value);
    } else {
      keep_joints(message);
    }
    return true;
  }

  void keep_joints(const BagMessage& message) {
    const auto index_of = [&](const char* name) {
      const auto found = std::find(joints_.names.begin(), joints_.names.end(), name);
      if (found == joints_.names.end())
        note(Defect::Kind::incomplete, joints_topic, message.time,
             fmt::format("joint '{}' is missing", name));
      return static_cast<std::size_t>(found - joints_.names.begin());
    };
    const std::size_t carriage = index_of("carriage");
    const std::size_t wheel = index_of("wheel");
    const auto value = [&](const std::vector<double>& values, std::size_t index, const char* what) {
      if (index < values.size()) return values[index];
      if (index < joints_.names.size())
        note(Defect::Kind::incomplete, joints_topic, message.time,
             fmt::format("{} of joint '{}' is missing", what, joints_.names[index]));
      return missing;
    };
    run_log::JointSeries& series = recording_.log.joints;
    series.carriage_position.push_back(value(joints_.position, carriage, "position"));
    series.carriage_velocity.push_back(value(joints_.velocity, carriage, "velocity"));
    series.wheel_angle.push_back(value(joints_.position, wheel, "position"));
    series.wheel_rate.push_back(value(joints_.velocity, wheel, "velocity"));
    series.wheel_effort.push_back(value(joints_.effort, wheel, "effort"));
  }

  void finish(const ScanSummary& summary) {
    const std::int64_t epoch = find_epoch();
    run_log::RunLog& log = recording_.log;
    const std::int64_t microseconds = epoch / 1000;
    log.epoch = static_cast<double>(microseconds) / 1e6;
    const auto seconds = [epoch](const std::vector<std::int64_t>& from, std::vector<double>& to) {
      to.resize(from.size());
      std::transform(from.begin(), from.end(), to.begin(),
                     [epoch](std::int64_t t) { return seconds_since(epoch, t); });
    };
    seconds(ft_.stamp, log.ft.time);
    seconds(ft_.arrival, recording_.ft_arrival);
    seconds(draw_wire_.stamp, log.draw_wire.time);
    seconds(draw_wire_.arrival, recording_.draw_wire_arrival);
    seconds(joint_times_.stamp, log.joints.time);
    seconds(joint_times_.arrival, recording_.joints_arrival);
    seconds(temperature_.stamp, log.temperature.time);
    seconds(temperature_.arrival, recording_.temperature_arrival);
    for (std::size_t i = 0; i < recording_.defects.size(); ++i)
      recording_.defects[i].first_time = seconds_since(epoch, first_arrivals_[i]);
    for (const BagDamage& damage : summary.damage)
      recording_.defects.push_back(
          {Defect::Kind::damage, "", 1, missing, fmt::format("byte {}: {}", damage.offset, damage.text)});
    if (summary.damage_count > summary.damage.size())
      recording_.defects.push_back({Defect::Kind::damage, "", summary.damage_count - summary.damage.size(),
                                    missing, "more damaged places"});
    if (summary.has_uncompressed_chunks)
      recording_.defects.push_back(
          {Defect::Kind::no_checksum, "", 1, missing,
           "chunks are not compressed and carry no checksum: a damaged value cannot be seen"});
    if (!summary.indexed)
      recording_.defects.push_back({Defect::Kind::damage, "", 1, missing,
                                    "the bag has no index: its recorder did not finish, or its end is lost"});
  }

  /// Earliest stamp that is credible, in whole microseconds.
  std::int64_t find_epoch() const {
    std::vector<std::int64_t> stamps;
    for (const Times* times : {&ft_, &draw_wire_, &joint_times_, &temperature_})
      stamps.insert(stamps.end(), times->stamp.begin(), times->stamp.end());
    if (stamps.empty()) return 0;
    const auto middle = stamps.begin() + static_cast<std::ptrdiff_t>(stamps.size() / 2);
    std::nth_element(stamps.begin(), middle, stamps.end());
    std::int64_t earliest = *middle;
    for (const std::int64_t stamp : stamps)
      if (std::abs(stamp - *middle) < credible_span) earliest = std::min(earliest, stamp);
    return earliest / 1000 * 1000;
  }

  Recording recording_;
  std::vector<std::int64_t> first_arrivals_;  // of the defects
  Times ft_, draw_wire_, joint_times_, temperature_;
  WrenchMessage wrench_;
  ScalarMessage scalar_;
  JointMessage joints_;
};

/// The samples to keep of a series, in order of their stamps.
template <typename IsFinite>
std::vector<std::size_t> order_of(const std::vector<double>& time, IsFinite is_finite) {
  std::vector<std::size_t> order(time.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return time[a] < time[b]; });
  std::vector<std::size_t> kept;
  for (const std::size_t i : order)
    if (is_finite(i) && (kept.empty() || time[i] > time[kept.back()])) kept.push_back(i);
  return kept;
}

template <typename T>
void select(std::vector<T>& values, const std::vector<std::size_t>& kept) {
  if (values.empty()) return;
  std::vector<T> selected;
  selected.reserve(kept.size());
  for (const std::size_t i : kept) selected.push_back(values[i]);
  values = std::move(selected);
}

void clean(run_log::ScalarSeries& series) {
  const auto kept = order_of(series.time, [&](std::size_t i) { return std::isfinite(series.value[i]); });
  select(series.time, kept);
  select(series.value, kept);
}

}  // namespace

Recording read_recording(ByteSource& source, const std::string& name) {
  return Reader().read(source, name);
}

Recording read_recording(const std::string& path) {
  FileSource source(path);
  return read_recording(source, path);
}

run_log::RunLog cleaned(run_log::RunLog log) {
  const auto wrench = order_of(log.ft.time, [&](std::size_t i) {
    return log.ft.force[i].allFinite() && log.ft.torque[i].allFinite();
  });
  select(log.ft.time, wrench);
  select(log.ft.force, wrench);
  select(log.ft.torque, wrench);
  clean(log.draw_wire);
  clean(log.temperature);
  run_log::JointSeries& joints = log.joints;
  const std::vector<std::vector<double>*> columns{&joints.carriage_position, &joints.carriage_velocity,
                                                  &joints.wheel_angle, &joints.wheel_rate,
                                                  &joints.wheel_effort};
  for (auto* column : columns)
    if (std::none_of(column->begin(), column->end(), [](double value) { return std::isfinite(value); }))
      column->clear();
  const auto kept = order_of(joints.time, [&](std::size_t i) {
    return std::all_of(columns.begin(), columns.end(),
                       [i](auto* c) { return c->empty() || std::isfinite((*c)[i]); });
  });
  select(joints.time, kept);
  for (auto* column : columns) select(*column, kept);
  return log;
}

run_log::RunLog read_run_log(const std::string& path) {
  Recording recording = read_recording(path);
  for (const Defect& defect : recording.defects)
    if (defect.kind == Defect::Kind::refused)
      throw Error(fmt::format("{}: {}: {}", path, defect.topic, defect.text));
  return cleaned(std::move(recording.log));
}

}  // namespace wheel_twin::logs
