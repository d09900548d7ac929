// The co-simulated contact by the names of its parts in `config/`: wheel, soil, and how they are
// co-simulated.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "cosim/dem_contact.h"
#include "rig/ports.h"

namespace wheel_twin::twin {

/// Names of files in config/, or paths.
struct DemRigNames {
  std::string wheel = "amalia";
  std::string soil = "mars_simulant";
  std::string settings = "paper";  ///< config/dem
};

/// Fetches the bed, or makes it. What `ports` point to must outlive the contact. Throws Error naming file,
/// line and key, or what does not go together.
std::unique_ptr<cosim::DemContact> make_dem_contact(const DemRigNames& names,
                                                    const cosim::DemSettings& settings,
                                                    const rig::Ports& ports, int threads);

}  // namespace wheel_twin::twin
