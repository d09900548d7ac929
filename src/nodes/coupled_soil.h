// Discrete-element soil for a wheel in another node: takes where the rim segments are step by step
// (wheel/segments) and answers what the soil exerts on each (soil/segment_loads). Frame `rig`, SI units.
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <string>

#include "cosim/dem_settings.h"
#include "cosim/dem_soil.h"
#include "dem/bed.h"
#include "dem/granular_soil.h"
#include "wheel/wheel_model.h"

namespace wheel_twin::nodes {

struct CoupledSoilSettings {
  wheel::WheelModel model;
  dem::GranularSoil soil;  ///< as scaled by `dem`
  std::string soil_name;
  cosim::DemSettings dem;
  int threads = 1;
  double patience = 30.0;  ///< s that the wheel may be silent during a run
};

struct CoupledSoilHooks {
  std::function<bool()> quit;  ///< the node ends
  /// The settled bed; waits for it. Throws Error when there is none, NodeEnds when the node ends.
  std::function<const dem::Bed&()> bed;
  std::function<void(const std::string&)> state;  ///< ready, running, failed: why
  /// After every step, while the wheel takes its own; `at_rest`: when time stands still and at the end.
  /// `hub_x`: place of the wheel, m.
  std::function<void(const cosim::DemSoil&, double hub_x, bool at_rest)> shown;
};

/// Serves run after run until the node ends.
void serve_coupled_soil(const ros::NodeHandle& node, const CoupledSoilSettings& settings,
                        const CoupledSoilHooks& hooks);

}  // namespace wheel_twin::nodes
