// The node `flexible_wheel`: a multibody wheel that rolls under a load over hard ground by itself (`drive`
// roll, a demonstration), stands between virtual_rig and dem_soil (`drive` soil: nodes/coupled_wheel.h), or
// takes hub motion and forces on its segments step by step (`drive` commands: WheelCommand in, WheelState
// out, lock-step by number; the first state comes latched).
// Topics out: wheel/joint_states, wheel/markers, wheel/ground (MarkerArray, latched), wheel/deflection,
// wheel/reaction, wheel/state, wheel/status (String, latched: settling, rolling, held, waiting, failed: why);
// in: wheel/command. tf: frame_id -> hub_frame -> wheel_frame.
// Parameters: wheel, drive; of the demonstration: ground (name in config/grounds, a file, or floor), load
// (N), speed (m/s), travel (m, then it stands still), real_time_factor (0: as fast as it goes), angle (rad);
// of commands: hub_height (m); of soil: patience (s that the others may be silent during a run);
// publish_rate (Hz of simulated time, of soil: of wall time), frame_id, hub_frame, wheel_frame.
#pragma once

#include <ros/node_handle.h>

#include <memory>

namespace wheel_twin::nodes {

class FlexibleWheelBridge {
 public:
  /// Throws Error naming the parameter or file that is wrong.
  FlexibleWheelBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ~FlexibleWheelBridge();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::nodes
