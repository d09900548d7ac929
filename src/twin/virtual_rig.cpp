#include "twin/virtual_rig.h"

#include <fmt/format.h>

#include "base/config_path.h"
#include "base/error.h"
#include "base/yaml.h"
#include "rig/semi_empirical_contact.h"
#include "twin/dem_rig.h"

namespace wheel_twin::twin {
namespace {

yaml::Map config(const std::string& kind, const std::string& name) {
  return yaml::parse_file(find_config(kind, name));
}

}  // namespace

VirtualRig load_virtual_rig(const VirtualRigNames& names) {
  VirtualRig loaded;
  loaded.wheel_name = names.wheel;
  loaded.soil_name = names.soil;
  loaded.wheel = terramechanics::read_wheel(config("wheels", names.wheel));
  loaded.soil = terramechanics::read_soil(config("soils", names.soil));
  loaded.run.rig = rig::read_rig(config("rigs", names.rig));
  loaded.run.sensors.ft = rig::read_ft(config("sensors", names.ft));
  loaded.run.sensors.draw_wire = rig::read_draw_wire(config("sensors", names.draw_wire));
  loaded.run.sensors.joints = rig::read_joints(config("sensors", names.joints));
  loaded.run.sensors.temperature = rig::read_temperature(config("sensors", names.thermometer));
  loaded.run.radius = loaded.wheel.radius;
  return loaded;
}

std::unique_ptr<rig::Contact> make_contact(const std::string& fidelity, const terramechanics::Wheel& wheel,
                                           const terramechanics::Soil& soil, const rig::Ports& ports) {
  if (fidelity == "semi_empirical") return std::make_unique<rig::SemiEmpiricalContact>(wheel, soil, ports);
  if (fidelity == "dem") {
    const DemRigNames names{wheel.name, soil.name};
    return make_dem_contact(names, cosim::load_dem_settings(names.settings), ports, 1);
  }
  throw Error(fmt::format("fidelity '{}': semi_empirical and dem are known", fidelity));
}

}  // namespace wheel_twin::twin
