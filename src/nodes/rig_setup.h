// What a node's parameters say about the rig, its wheel, soil and sensors: names of files in the
// configuration folder (or paths), and what the operator sets for a run.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cosim/dem_settings.h"
#include "nodes/params.h"
#include "rig/contact.h"
#include "rig/free_run.h"
#include "terramechanics/soil.h"
#include "terramechanics/wheel.h"
#include "twin/twin_config.h"

namespace wheel_twin::nodes {

struct RigSetup {
  terramechanics::Wheel wheel;
  terramechanics::Soil soil;
  rig::RunSettings run;
  std::optional<twin::TwinConfig> twin;   ///< a twin file, whose wheel, soil and mount these are
  std::optional<cosim::DemSettings> dem;  ///< fidelity dem: how wheel and soil are co-simulated
  std::string title;                      ///< two lines for the view
};

/// Throws Error naming the parameter, or file, line and key.
RigSetup read_rig_setup(Params& params);

/// The setup of a twin file (revised_twin.yaml): its wheel, soil and mount, its effects and corrections on
/// top.
void take_twin(RigSetup& setup, const std::string& path);

/// The semi-empirical soil and wheel that carry the rig. What `ports` point to must outlive it. Throws Error
/// when they make no model.
std::unique_ptr<rig::Contact> make_contact(const RigSetup& setup, const rig::Ports& ports);

}  // namespace wheel_twin::nodes
