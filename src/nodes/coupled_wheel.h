// The flexible wheel between rig and discrete-element soil in other nodes: takes the hub's motion step by
// step (rig/hub_motion), moves the wheel in the soil's steps, each one an exchange with dem_soil
// (wheel/segments, soil/segment_loads), and answers the hub's load (wheel/hub_load). The same numbers as in
// one process. Keeps the checkpoint of all. SI units.
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <string>

#include "wheel/wheel_model.h"

namespace wheel_twin::wheel {
class FlexibleWheel;
}

namespace wheel_twin::nodes {

struct CoupledWheelSettings {
  wheel::WheelModel model;
  double patience = 30.0;  ///< s that rig or soil may be silent during a run
};

struct CoupledWheelHooks {
  std::function<bool()> quit;                      ///< the node ends
  std::function<void(const std::string&)> status;  ///< waiting, running, failed: why
  /// After every step of the rig; `at_rest`: when time stands still and at the end.
  std::function<void(const wheel::FlexibleWheel&, bool at_rest)> shown;
};

/// Serves run after run until the node ends.
void serve_coupled_wheel(const ros::NodeHandle& node, const CoupledWheelSettings& settings,
                         const CoupledWheelHooks& hooks);

}  // namespace wheel_twin::nodes
