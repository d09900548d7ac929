// The node `dem_soil`: a settled discrete-element bed. Prepares (or fetches) it in the background, shows it,
// lets it be saved; with `wheel` set it is the soil of that wheel in a co-simulation (nodes/coupled_soil.h),
// its bed and grains those of `dem` (a name in config/dem). Topics: soil/cloud, soil/height_map (PointCloud2,
// at `publish_rate`, 2 Hz at most), soil/rut (Marker), soil/state (String, latched: empty, preparing, ready,
// running, failed: why), diagnostics. Services: soil/prepare, soil/save (std_srvs/Trigger). Parameters: soil,
// length, width, depth, seed, fill_friction (tuned where not set), threads, save_path, wheel, dem, patience
// (s that the wheel may be silent), frame_id, publish_rate, rut_half_width, prepare_at_start. Frame: x along
// travel, z up, 0 at the mean surface.
#pragma once

#include <ros/node_handle.h>

#include <memory>

namespace wheel_twin::nodes {

class DemSoilBridge {
 public:
  /// Throws Error naming the parameter or file that is wrong.
  DemSoilBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ~DemSoilBridge();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::nodes
