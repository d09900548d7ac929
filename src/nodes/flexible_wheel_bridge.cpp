#include "nodes/flexible_wheel_bridge.h"

#include <fmt/format.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/console.h>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <std_msgs/String.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <thread>

#include "base/config_path.h"
#include "base/error.h"
#include "nodes/coupled_wheel.h"
#include "nodes/msg_conversion.h"
#include "nodes/pacer.h"
#include "nodes/params.h"
#include "nodes/wheel_conversion.h"
#include "wheel/rolling_wheel.h"

namespace wheel_twin::nodes {
namespace {

struct Settings {
  wheel::WheelModel model;
  std::string drive;
  double patience = 30.0;
  wheel::RollingSettings rolling;
  double travel = 0.3, real_time_factor = 0.2, publish_rate = 50.0, hub_height = 0.0;
  std::string frame, hub_frame, wheel_frame;
};

Settings read_settings(const ros::NodeHandle& node) {
  Params params = params_of(node);
  Settings s;
  s.model = wheel::read_wheel_file(find_config("wheels", params.text("wheel", "amalia")));
  s.drive = params.choice("drive", "roll", {"roll", "commands", "soil"});
  s.patience = params.number("patience", s.patience, {0.1, 1.0e4});
  s.rolling.load = params.number("load", 42.1, {0.1, 1.0e4});
  s.rolling.speed = params.number("speed", 0.1, {0.001, 2.0});
  s.rolling.start_angle = params.number("angle", 0.0, {-10.0, 10.0});
  const std::string ground = params.text("ground", "floor");
  if (ground == "floor")
    s.rolling.ground.contact = {5.0e5, 5.0, 0.8};
  else
    s.rolling.ground = wheel::read_ground_file(find_config("grounds", ground));
  s.travel = params.number("travel", s.travel, {0.0, 100.0});
  s.real_time_factor = params.number("real_time_factor", s.real_time_factor, {0.0, 1.0e3});
  s.publish_rate = params.number("publish_rate", s.publish_rate, {0.1, 1.0e4});
  s.hub_height = params.number("hub_height", s.model.radius + s.model.grouser_height, {-10.0, 10.0});
  s.frame = params.text("frame_id", "rig");
  s.hub_frame = params.text("hub_frame", "hub");
  s.wheel_frame = params.text("wheel_frame", "wheel");
  params.finish();
  return s;
}

}  // namespace

class FlexibleWheelBridge::Impl {
 public:
  Impl(ros::NodeHandle node, const ros::NodeHandle& private_node)
      : settings_(read_settings(private_node)), node_(std::move(node)), pacer_(settings_.real_time_factor) {
    joints_ = node_.advertise<sensor_msgs::JointState>("wheel/joint_states", 100, true);
    markers_ = node_.advertise<visualization_msgs::MarkerArray>("wheel/markers", 2, true);
    ground_ = node_.advertise<visualization_msgs::MarkerArray>("wheel/ground", 1, true);
    deflection_ = node_.advertise<DisplacementStamped>("wheel/deflection", 1000, true);
    reaction_ = node_.advertise<geometry_msgs::WrenchStamped>("wheel/reaction", 1000, true);
    state_ = node_.advertise<WheelState>("wheel/state", 1000, true);
    status_ = node_.advertise<std_msgs::String>("wheel/status", 10, true);
    if (settings_.drive == "soil") {
      worker_ = std::thread([this] { serve_rig(); });
      return;
    }
    if (settings_.drive == "roll") {
      rolling_ = std::make_unique<wheel::RollingWheel>(settings_.model, settings_.rolling);
      ground_.publish(ground_markers(settings_.rolling.ground, settings_.frame));
      worker_ = std::thread([this] { roll(); });
      return;
    }
    commanded_ = std::make_unique<wheel::FlexibleWheel>(settings_.model);
    wheel::HubMotion hub;
    hub.position.z() = settings_.hub_height;
    commanded_->place(hub);
    publish_all(*commanded_, 0.0, "");
    state_.publish(wheel_state(*commanded_, header()));
    set_status("waiting");
    command_ = node_.subscribe("wheel/command", 1000, &Impl::on_command, this);
  }

  ~Impl() {
    quit_ = true;
    pacer_.interrupt();
    if (worker_.joinable()) worker_.join();
  }

 private:
  std_msgs::Header header() const {
    std_msgs::Header h;
    h.stamp = ros::Time::now();
    h.frame_id = settings_.frame;
    return h;
  }

  void set_status(const std::string& status) {
    std_msgs::String message;
    message.data = status;
    status_.publish(message);
  }

  void publish_tf(const wheel::FlexibleWheel& wheel, const ros::Time& stamp) {
    const wheel::HubMotion hub = wheel.hub();
    geometry_msgs::TransformStamped to_hub, to_wheel;
    to_hub.header.stamp = to_wheel.header.stamp = stamp;
    to_hub.header.frame_id = settings_.frame;
    to_hub.child_frame_id = to_wheel.header.frame_id = settings_.hub_frame;
    to_wheel.child_frame_id = settings_.wheel_frame;
    to_hub.transform.translation.x = hub.position.x();
    to_hub.transform.translation.y = hub.position.y();
    to_hub.transform.translation.z = hub.position.z();
    to_hub.transform.rotation.z = std::sin(0.5 * hub.steering);
    to_hub.transform.rotation.w = std::cos(0.5 * hub.steering);
    to_wheel.transform.rotation.y = std::sin(0.5 * hub.angle);
    to_wheel.transform.rotation.w = std::cos(0.5 * hub.angle);
    tf_.sendTransform({to_hub, to_wheel});
  }

  void publish_all(const wheel::FlexibleWheel& wheel, double deflection, const std::string& text) {
    const std_msgs::Header h = header();
    joints_.publish(wheel_joints(wheel, h));
    deflection_.publish(to_message(h.stamp, settings_.hub_frame, deflection));
    const wheel::Wrench r = wheel.reaction();
    reaction_.publish(to_message(h.stamp, settings_.frame, r.force, r.torque));
    publish_tf(wheel, h.stamp);
    markers_.publish(wheel_markers(wheel, scale_, text, settings_.frame));
  }

  void publish_rolling() {
    const wheel::FlexibleWheel& wheel = rolling_->wheel();
    const double deflection = rolling_->deflection();
    publish_all(wheel, deflection,
                fmt::format("{}, {:.1f} N: deflection {:.2f} mm", settings_.model.name,
                            settings_.rolling.load, 1e3 * deflection));
    state_.publish(wheel_state(wheel, header()));
  }

  void roll() {
    try {
      set_status("settling");
      publish_rolling();
      rolling_->settle(1.0e-5, [this] { return quit_.load(); });
      if (quit_) return;
      set_status("rolling");
      pacer_.start();
      double due = 0.0;
      while (!quit_ && rolling_->wheel().hub().position.x() < settings_.travel) {
        if (rolling_->time() >= due) {
          due += 1.0 / settings_.publish_rate;
          publish_rolling();
          if (!pacer_.wait_until(rolling_->time())) return;
        }
        rolling_->step();
      }
      publish_rolling();
      set_status("held");
    } catch (const std::exception& error) {
      fail(error.what());
    }
  }

  void on_command(const WheelCommand::ConstPtr& command) {
    if (failed_) return;
    try {
      obey(*commanded_, *command);
      time_ += command->time_step;
      state_.publish(wheel_state(*commanded_, header()));
      if (time_ < shown_) return;
      shown_ += 1.0 / settings_.publish_rate;
      publish_all(*commanded_, 0.0, "");
    } catch (const std::exception& error) {
      failed_ = true;
      fail(error.what());
    }
  }

  /// Between rig and soil of other nodes.
  void serve_rig() {
    CoupledWheelHooks hooks;
    hooks.quit = [this] { return quit_.load(); };
    hooks.status = [this](const std::string& status) { set_status(status); };
    hooks.shown = [this](const wheel::FlexibleWheel& wheel, bool at_rest) {
      const ros::WallTime now = ros::WallTime::now();
      if (now < due_ && !at_rest) return;
      due_ = now + ros::WallDuration(1.0 / settings_.publish_rate);
      if (at_rest || joints_.getNumSubscribers() > 0) joints_.publish(wheel_joints(wheel, header()));
      if (at_rest || markers_.getNumSubscribers() > 0)
        markers_.publish(wheel_markers(wheel, scale_, "", settings_.frame));
    };
    serve_coupled_wheel(node_, {settings_.model, settings_.patience}, hooks);
  }

  void fail(const char* why) {
    ROS_ERROR("flexible_wheel: %s", why);
    set_status(std::string("failed: ") + why);
  }

  Settings settings_;
  ros::NodeHandle node_;
  Pacer pacer_;
  tf2_ros::TransformBroadcaster tf_;
  ros::Publisher joints_, markers_, ground_, deflection_, reaction_, state_, status_;
  BendingScale scale_;
  std::unique_ptr<wheel::RollingWheel> rolling_;
  std::unique_ptr<wheel::FlexibleWheel> commanded_;
  double time_ = 0.0, shown_ = 0.0;  // of commands, s
  ros::WallTime due_;                // next pictures of a coupled wheel
  bool failed_ = false;
  std::atomic<bool> quit_{false};
  ros::Subscriber command_;
  std::thread worker_;
};

FlexibleWheelBridge::FlexibleWheelBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : impl_(std::make_unique<Impl>(node, private_node)) {}

FlexibleWheelBridge::~FlexibleWheelBridge() = default;

}  // namespace wheel_twin::nodes
