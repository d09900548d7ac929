#include "nodes/live_twin_bridge.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <fmt/format.h>
#include <ros/console.h>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <ros/this_node.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "base/error.h"
#include "nodes/follower.h"
#include "nodes/live_suspect.h"
#include "nodes/msg_conversion.h"
#include "nodes/params.h"
#include "nodes/replay_twin.h"
#include "nodes/residual_watch.h"
#include "nodes/rig_view.h"

namespace wheel_twin::nodes {
namespace {

constexpr int queue = 4000;              // messages of a topic that may wait
constexpr double watch_window = 5.0;     // s over which residuals are judged
constexpr double rolling_speed = 0.002;  // m/s; slower, slip is mostly noise and its residual is not judged
constexpr double silence = 2.0;          // wall s after which a topic counts as missing

struct Settings {
  RigSetup setup;
  FollowerSettings follower;
  double pull_limit = 3.0;
  double displacement_limit = 0.003;
  double effort_limit = 0.5;
  bool show = false;
};

Settings read_settings(const ros::NodeHandle& node) {
  Params params = params_of(node);
  Settings s;
  s.setup = read_rig_setup(params);
  if (s.setup.dem)
    throw Error(
        fmt::format("parameter {}/fidelity: a twin in real time is semi_empirical", node.getNamespace()));
  if (const std::string twin = params.text("twin", ""); !twin.empty()) take_twin(s.setup, twin);
  FollowerSettings& f = s.follower;
  f.rate = params.number("rate", f.rate, {1.0, 2000.0});
  f.longest_wait = params.number("longest_wait", f.longest_wait, {0.0, 10.0});
  f.longest_gap = params.number("longest_gap", f.longest_gap, {1e-3, 10.0});
  f.jump = params.number("jump", f.jump, {1e-3, 1e6});
  f.measured_load = params.choice("load_from", "measured", {"measured", "declared"}) == "measured";
  f.load_filter = params.number("load_filter", f.load_filter, {0.0, 100.0});
  f.declared_load = s.setup.run.conditions.load;
  f.steering_angle = s.setup.run.conditions.steering_angle;
  s.pull_limit = params.number("drawbar_pull_limit", s.pull_limit, yaml::positive());
  s.displacement_limit = params.number("hub_displacement_limit", s.displacement_limit, yaml::positive());
  s.effort_limit = params.number("motor_effort_limit", s.effort_limit, yaml::positive());
  s.show = params.boolean("show", false);
  params.finish();
  return s;
}

/// What the watches let pass, as a band about the twin; channels that are not watched get one in proportion.
SuspectBand suspect_band(const Settings& s) {
  return {s.pull_limit, s.displacement_limit, s.effort_limit};
}

/// When a topic last spoke, and how often.
struct Heard {
  ros::WallTime last;
  std::size_t messages = 0;
  void now() {
    last = ros::WallTime::now();
    ++messages;
  }
  bool silent() const { return messages == 0 || (ros::WallTime::now() - last).toSec() > silence; }
};

}  // namespace

class LiveTwinBridge::Impl {
 public:
  Impl(ros::NodeHandle node, const ros::NodeHandle& private_node)
      : settings_(read_settings(private_node)),
        node_(node),
        follower_(settings_.follower, std::make_unique<ReplayTwin>(settings_.setup)),
        pull_(window_ticks(), settings_.pull_limit),
        sinkage_(window_ticks(), settings_.displacement_limit),
        effort_(window_ticks(), settings_.effort_limit),
        suspect_(settings_.setup, suspect_band(settings_)),
        updater_(node, private_node, ros::this_node::getName()) {
    twin_wrench_ = node_.advertise<geometry_msgs::WrenchStamped>("twin/wrench", queue);
    twin_displacement_ = node_.advertise<DisplacementStamped>("twin/displacement", queue);
    twin_joints_ = node_.advertise<sensor_msgs::JointState>("twin/joint_states", queue);
    residual_wrench_ = node_.advertise<geometry_msgs::WrenchStamped>("twin/residual/wrench", queue);
    residual_displacement_ = node_.advertise<DisplacementStamped>("twin/residual/displacement", queue);
    residual_joints_ = node_.advertise<sensor_msgs::JointState>("twin/residual/joint_states", queue);
    if (settings_.show) view_.emplace(node_, settings_.setup.wheel, settings_.setup.soil, "twin/labels");
    updater_.setHardwareID("none");
    updater_.add("live twin", this, &Impl::diagnose);
    if (settings_.show) status_ = node_.advertise<std_msgs::String>("rig/status", 10, true);
    timer_ = node_.createWallTimer(ros::WallDuration(1.0),
                                   [this](const ros::WallTimerEvent&) { updater_.force_update(); });
    const auto hints = ros::TransportHints().tcpNoDelay();
    wrench_ = node_.subscribe("ft_sensor/wrench", queue, &Impl::on_wrench, this, hints);
    displacement_ = node_.subscribe("draw_wire/displacement", queue, &Impl::on_displacement, this, hints);
    temperature_ = node_.subscribe("rig/temperature", 10, &Impl::on_temperature, this, hints);
    joints_ = node_.subscribe("rig/joint_states", queue, &Impl::on_joints, this, hints);
  }

 private:
  std::size_t window_ticks() const {
    return static_cast<std::size_t>(watch_window * settings_.follower.rate);
  }

  void on_wrench(const geometry_msgs::WrenchStamped::ConstPtr& message) {
    heard_wrench_.now();
    follower_.wrench(to_nanoseconds(message->header.stamp), from_message(*message));
    follow();
  }

  void on_displacement(const DisplacementStamped::ConstPtr& message) {
    heard_displacement_.now();
    follower_.displacement(to_nanoseconds(message->header.stamp), message->displacement);
    follow();
  }

  void on_temperature(const sensor_msgs::Temperature::ConstPtr& message) {
    follower_.temperature(message->temperature);
  }

  void on_joints(const sensor_msgs::JointState::ConstPtr& message) {
    const auto joints = from_message(*message);
    if (!joints) {
      ++foreign_joints_;
      return;
    }
    heard_joints_.now();
    follower_.joints(to_nanoseconds(message->header.stamp), *joints);
    follow();
  }

  void follow() {
    const std::size_t jumps = follower_.events().jumps + follower_.events().gaps;
    const ros::WallTime begin = ros::WallTime::now();
    std::vector<Tick> ticks;
    try {
      ticks = follower_.take();
      if (!ticks.empty()) failure_.clear();
    } catch (const Error& error) {
      failure_ = error.what();
      ROS_WARN_THROTTLE(1.0, "live_twin: %s", error.what());
    }
    if (follower_.events().jumps + follower_.events().gaps != jumps ||
        follower_.events().jumps != seen_jumps_) {
      seen_jumps_ = follower_.events().jumps;
      pull_.clear();
      sinkage_.clear();
      effort_.clear();
      suspect_.clear();
      if (view_) view_->clear();
    }
    for (const Tick& tick : ticks) publish(tick);
    if (ticks.empty()) return;
    ticks_ += ticks.size();
    slowest_ = std::max(slowest_, (ros::WallTime::now() - begin).toSec() / static_cast<double>(ticks.size()));
  }

  void publish(const Tick& tick) {
    const ros::Time stamp = to_stamp(tick.stamp);
    const auto& twin = tick.twin.readings;
    const bool rolls =
        std::max(std::abs(tick.motion.carriage_velocity),
                 std::abs(tick.motion.wheel_rate) * settings_.setup.wheel.radius) > rolling_speed;
    twin_wrench_.publish(to_message(stamp, "ft_sensor", twin.wrench.force, twin.wrench.torque));
    twin_displacement_.publish(to_message(stamp, "rig", twin.displacement));
    twin_joints_.publish(to_message(stamp, twin.joints));
    longest_delay_ = std::max(longest_delay_, 1e-9 * static_cast<double>(tick.delay));
    if (tick.wrench) {
      const Eigen::Vector3d force = tick.wrench->force - twin.wrench.force;
      residual_wrench_.publish(
          to_message(stamp, "ft_sensor", force, tick.wrench->torque - twin.wrench.torque));
      if (rolls) pull_.add(force.x());
    }
    if (tick.displacement) {
      residual_displacement_.publish(to_message(stamp, "rig", *tick.displacement - twin.displacement));
      sinkage_.add(*tick.displacement - twin.displacement);
    }
    if (tick.effort) {
      rig::JointReading residual;
      residual.wheel_effort = *tick.effort - twin.joints.wheel_effort;
      residual_joints_.publish(to_message(stamp, residual));
      if (rolls) effort_.add(residual.wheel_effort);
    }
    suspect_.add(tick);
    if (view_) show(tick);
  }

  void show(const Tick& tick) {
    Gauges gauges;
    gauges.title = settings_.setup.title;
    gauges.phase = "measured, twin (residual)";
    gauges.time = tick.motion.time;
    gauges.slip = tick.twin.state.slip;
    gauges.has_twin = true;
    gauges.twin = {tick.twin.readings.wrench.force, tick.twin.readings.displacement,
                   tick.twin.readings.joints.wheel_effort};
    gauges.measured = gauges.twin;
    if (tick.wrench) gauges.measured.force = tick.wrench->force;
    if (tick.displacement) gauges.measured.hub_displacement = *tick.displacement;
    if (tick.effort) gauges.measured.motor_effort = *tick.effort;
    view_->show(tick.motion.carriage_position, tick.motion.wheel_angle, tick.motion.steering_angle, gauges);
  }

  /// With `show`: waiting, following or silent on rig/status, when it changes.
  void say(const std::string& status) {
    if (!settings_.show || status == said_) return;
    said_ = status;
    std_msgs::String message;
    message.data = status;
    status_.publish(message);
    if (status == "silent") view_->flush();
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    using diagnostic_msgs::DiagnosticStatus;
    const FollowerEvents& events = follower_.events();
    status.summary(DiagnosticStatus::OK, "following");
    const auto topic = [&](const char* name, const Heard& heard, int level) {
      if (heard.silent()) status.mergeSummary(level, fmt::format("{} is silent", node_.resolveName(name)));
    };
    topic("rig/joint_states", heard_joints_, DiagnosticStatus::ERROR);
    say(heard_joints_.messages == 0 ? "waiting" : heard_joints_.silent() ? "silent" : "following");
    topic("ft_sensor/wrench", heard_wrench_, DiagnosticStatus::WARN);
    topic("draw_wire/displacement", heard_displacement_, DiagnosticStatus::WARN);
    if (!failure_.empty()) status.mergeSummary(DiagnosticStatus::ERROR, failure_);
    if (pull_.exceeded())
      status.mergeSummary(DiagnosticStatus::WARN, "drawbar pull is not what the twin predicts");
    if (sinkage_.exceeded())
      status.mergeSummary(DiagnosticStatus::WARN, "hub displacement is not what the twin predicts");
    if (effort_.exceeded())
      status.mergeSummary(DiagnosticStatus::WARN, "motor effort is not what the twin predicts");
    if (pull_.exceeded() || sinkage_.exceeded() || effort_.exceeded()) {
      suspect_.ask();
      if (const std::string suspect = suspect_.told(); !suspect.empty())
        status.mergeSummary(DiagnosticStatus::WARN, suspect);
    }
    status.add("likeliest effect", suspect_.told());
    // What happened since the last report.
    const auto fresh = [&](std::size_t now, std::size_t before, const char* what) {
      if (now > before) status.mergeSummary(DiagnosticStatus::WARN, fmt::format("{} {}", now - before, what));
    };
    fresh(events.jumps, reported_.jumps, "jumps of the clock");
    fresh(events.gaps, reported_.gaps, "gaps in the joint states");
    fresh(events.not_finite, reported_.not_finite, "samples that are not finite");
    fresh(events.repeated, reported_.repeated, "repeated or late stamps");
    fresh(events.time_zero, reported_.time_zero, "samples without a stamp");
    fresh(foreign_joints_, reported_foreign_, "joint states without carriage and wheel");
    status.add("ticks", ticks_);
    status.add("RMS residual of the drawbar pull (N)", pull_.rms());
    status.add("RMS residual of the hub displacement (m)", sinkage_.rms());
    status.add("RMS residual of the motor effort (N m)", effort_.rms());
    status.add("longest delay behind the newest stamp (s)", longest_delay_);
    status.add("longest computation of a tick (s)", slowest_);
    status.add("jumps of the clock", events.jumps);
    status.add("gaps in the joint states", events.gaps);
    status.add("samples that are not finite", events.not_finite);
    status.add("repeated or late stamps", events.repeated);
    status.add("samples without a stamp", events.time_zero);
    status.add("ticks without wrench or displacement", events.incomplete);
    status.add("ticks with the wheel hanging", events.hanging);
    reported_ = events;
    reported_foreign_ = foreign_joints_;
    longest_delay_ = slowest_ = 0.0;
  }

  Settings settings_;
  ros::NodeHandle node_;
  Follower follower_;
  ResidualWatch pull_, sinkage_, effort_;
  LiveSuspect suspect_;
  std::optional<RigView> view_;
  diagnostic_updater::Updater updater_;
  ros::Publisher twin_wrench_, twin_displacement_, twin_joints_;
  ros::Publisher status_;
  ros::Publisher residual_wrench_, residual_displacement_, residual_joints_;
  ros::Subscriber wrench_, displacement_, joints_, temperature_;
  ros::WallTimer timer_;
  Heard heard_wrench_, heard_displacement_, heard_joints_;
  FollowerEvents reported_;
  std::size_t foreign_joints_ = 0;
  std::size_t reported_foreign_ = 0;
  std::size_t seen_jumps_ = 0;
  std::size_t ticks_ = 0;
  double longest_delay_ = 0.0;
  double slowest_ = 0.0;
  std::string failure_;
  std::string said_;
};

LiveTwinBridge::LiveTwinBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : impl_(std::make_unique<Impl>(node, private_node)) {}
LiveTwinBridge::~LiveTwinBridge() = default;

}  // namespace wheel_twin::nodes
