// A virtual rig by the names of its parts in `config/`: wheel, soil, rig, sensors, and the soil's fidelity.
#pragma once

#include <memory>
#include <string>

#include "rig/contact.h"
#include "rig/free_run.h"
#include "terramechanics/soil.h"
#include "terramechanics/wheel.h"

namespace wheel_twin::twin {

/// Names of files in config/, or paths.
struct VirtualRigNames {
  std::string wheel = "amalia";
  std::string soil = "mars_simulant";
  std::string rig = "polito";
  std::string ft = "ati_mini45_si_145_5";
  std::string draw_wire = "micro_epsilon_draw_wire";
  std::string joints = "motor_joints";
  std::string thermometer = "thermometer";
};

struct VirtualRig {
  std::string wheel_name, soil_name;  ///< files in config/, for what the structures below do not hold
  terramechanics::Wheel wheel;
  terramechanics::Soil soil;
  rig::RunSettings run;  ///< rig, sensors and radius set; profile and conditions at their defaults
};

/// Throws Error naming file, line and key.
VirtualRig load_virtual_rig(const VirtualRigNames& names);

/// The contact of a fidelity: `semi_empirical`, or `dem` for the co-simulation on the paper's bed
/// (twin/dem_rig.h has the choices). What `ports` point to must outlive it. Throws Error for another name.
std::unique_ptr<rig::Contact> make_contact(const std::string& fidelity, const terramechanics::Wheel& wheel,
                                           const terramechanics::Soil& soil, const rig::Ports& ports);

}  // namespace wheel_twin::twin
