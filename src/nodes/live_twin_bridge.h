// The node `live_twin`: follows a real or replayed rig by its topics, leads the real-time twin along the
// measured motion and publishes prediction (twin/...), residual = measured - twin (twin/residual/...) and
// diagnostics at 1 Hz. doc/architecture.md, "ROS", lists topics and parameters.
#pragma once

#include <ros/node_handle.h>

#include <memory>

namespace wheel_twin::nodes {

class LiveTwinBridge {
 public:
  /// Throws Error naming the parameter, file or key that is wrong.
  LiveTwinBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ~LiveTwinBridge();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::nodes
