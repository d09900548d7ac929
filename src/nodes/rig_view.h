// Publishes what a person sees of a rig: its pose (rig/model_states for robot_state_publisher), soil surface,
// rut and trace, forces and numbers. Each at a rate that rviz can draw, whatever the rate of the calls. The
// pose carries the time at which it is shown and is sent again while the rig stands, for viewers that come
// later. May be used from any thread.
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/wall_timer.h>

#include <mutex>
#include <string>

#include "nodes/msg_conversion.h"
#include "nodes/scene.h"
#include "terramechanics/soil.h"
#include "terramechanics/wheel.h"

namespace wheel_twin::nodes {

class RigView {
 public:
  /// `labels_topic`: where forces and numbers go. `draws_soil`: the surface and the rut from the wheel's
  /// path; not where the soil draws itself.
  RigView(ros::NodeHandle node, const terramechanics::Wheel& wheel, const terramechanics::Soil& soil,
          const std::string& labels_topic, bool draws_soil = true);

  void clear();  ///< an untouched bed, no trace
  /// The state of the rig; `gauges.hub` and `gauges.radius` are filled in here. `steering` rad.
  void show(double carriage, double wheel_angle, double steering, Gauges gauges);
  void flush();  ///< publishes the last state, whatever the rates

 private:
  void publish(bool everything);
  void send_pose();

  std::mutex mutex_;

  bool draws_soil_;
  terramechanics::Wheel wheel_;
  BinSize bin_;
  Rut rut_;
  Trace trace_;
  Gauges gauges_;
  ModelPose pose_;
  ros::Publisher model_, surface_, path_, labels_;
  ros::WallTimer again_;
  ros::WallTime model_due_, labels_due_, surface_due_;
};

}  // namespace wheel_twin::nodes
