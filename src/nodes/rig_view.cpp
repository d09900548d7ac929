#include "nodes/rig_view.h"

#include <algorithm>

namespace wheel_twin::nodes {
namespace {

constexpr double model_period = 1.0 / 30.0;  // wall s
constexpr double again_period = 0.1;
constexpr double labels_period = 0.1;
constexpr double surface_period = 1.0;

RutSettings rut_settings(const terramechanics::Wheel& wheel, const terramechanics::Soil& soil,
                         const BinSize& bin) {
  RutSettings settings;
  settings.begin = bin.length_begin;
  settings.end = bin.length_end;
  settings.radius = wheel.radius;
  settings.grousers = wheel.grousers;
  settings.grouser_height = wheel.grouser_height;
  settings.rebound = std::clamp(soil.gamma, 0.0, 1.0);
  return settings;
}

bool due(ros::WallTime& next, double period, bool everything) {
  const ros::WallTime now = ros::WallTime::now();
  if (!everything && now < next) return false;
  next = now + ros::WallDuration(period);
  return true;
}

}  // namespace

RigView::RigView(ros::NodeHandle node, const terramechanics::Wheel& wheel, const terramechanics::Soil& soil,
                 const std::string& labels_topic, bool draws_soil)
    : draws_soil_(draws_soil), wheel_(wheel), rut_(rut_settings(wheel, soil, bin_)) {
  bin_.repose_angle = soil.phi;
  model_ = node.advertise<sensor_msgs::JointState>("rig/model_states", 10, true);
  if (draws_soil_) surface_ = node.advertise<visualization_msgs::Marker>("soil/surface", 1, true);
  if (draws_soil_) path_ = node.advertise<visualization_msgs::MarkerArray>("soil/rut", 1, true);
  labels_ = node.advertise<visualization_msgs::MarkerArray>(labels_topic, 1, true);
  pose_.hub_height = wheel.radius;
  again_ = node.createWallTimer(ros::WallDuration(again_period), [this](const ros::WallTimerEvent&) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (ros::WallTime::now() > model_due_ + ros::WallDuration(again_period)) send_pose();
  });
}

void RigView::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  rut_ = Rut(rut_.settings());
  trace_.clear();
}

void RigView::show(double carriage, double wheel_angle, double steering, Gauges gauges) {
  const std::lock_guard<std::mutex> lock(mutex_);
  gauges_ = std::move(gauges);
  const auto& measured = gauges_.measured;
  pose_ = {carriage, wheel_.radius - measured.hub_displacement, steering, wheel_angle};
  gauges_.hub = {carriage, 0.0, pose_.hub_height};
  gauges_.radius = wheel_.radius;
  const double deflection = wheel_.stiffness ? std::max(0.0, measured.force.z()) / *wheel_.stiffness : 0.0;
  rut_.roll(carriage, measured.hub_displacement - deflection, wheel_angle);
  trace_.add(gauges_.hub);
  publish(false);
}

void RigView::flush() {
  const std::lock_guard<std::mutex> lock(mutex_);
  publish(true);
}

void RigView::send_pose() {
  if (ros::Time::isValid()) model_.publish(to_message(ros::Time::now(), pose_));
}

void RigView::publish(bool everything) {
  if (due(model_due_, model_period, everything)) send_pose();
  if (due(labels_due_, labels_period, everything)) labels_.publish(labels(gauges_));
  if (!draws_soil_ || !due(surface_due_, surface_period, everything)) return;
  surface_.publish(soil_surface(rut_, bin_, wheel_.width));
  path_.publish(trace_.markers(rut_));
}

}  // namespace wheel_twin::nodes
