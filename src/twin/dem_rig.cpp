#include "twin/dem_rig.h"

#include "base/config_path.h"
#include "dem/granular_soil.h"
#include "wheel/wheel_model.h"

namespace wheel_twin::twin {

std::unique_ptr<cosim::DemContact> make_dem_contact(const DemRigNames& names,
                                                    const cosim::DemSettings& settings,
                                                    const rig::Ports& ports, int threads) {
  const wheel::WheelModel wheel = wheel::read_wheel_file(find_config("wheels", names.wheel));
  const dem::GranularSoil soil = dem::load_granular_soil(names.soil);
  return std::make_unique<cosim::DemContact>(wheel, soil, settings, ports, threads);
}

}  // namespace wheel_twin::twin
