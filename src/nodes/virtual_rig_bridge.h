// The node `virtual_rig`: a live single-wheel rig. Publishes wrench, displacement, joint states and
// temperature at the sensors' rates, the pose of the rig for robot_state_publisher, markers for rviz and
// diagnostics at 1 Hz; offers the services rig/start, rig/stop and ft_sensor/bias; writes the bag of each run
// directly. doc/architecture.md, "ROS", lists topics, services and parameters.
#pragma once

#include <ros/node_handle.h>

#include <memory>

namespace wheel_twin::nodes {

class VirtualRigBridge {
 public:
  /// Throws Error naming the parameter, file or key that is wrong.
  VirtualRigBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ~VirtualRigBridge();  ///< ends a run at once; its bag is closed and complete up to then

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::nodes
