#include "nodes/rig_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "twin/virtual_rig.h"

namespace wheel_twin::nodes {
RigSetup read_rig_setup(Params& params) {
  twin::VirtualRigNames names;
  names.wheel = params.text("wheel", names.wheel);
  names.soil = params.text("soil", names.soil);
  names.rig = params.text("rig", names.rig);
  names.ft = params.text("ft_sensor", names.ft);
  names.draw_wire = params.text("draw_wire", names.draw_wire);
  names.joints = params.text("joints", names.joints);
  names.thermometer = params.text("thermometer", names.thermometer);
  twin::VirtualRig loaded = twin::load_virtual_rig(names);
  RigSetup setup;
  setup.wheel = std::move(loaded.wheel);
  setup.soil = std::move(loaded.soil);
  setup.run = std::move(loaded.run);

  rig::RunSettings& run = setup.run;
  if (params.choice("fidelity", "semi_empirical", {"dem", "semi_empirical"}) == "dem") {
    setup.dem = cosim::load_dem_settings(params.text("dem", "paper"));
    run.profile = setup.dem->profile;
  }
  if (const auto rate = params.optional_number("publish_rate", {1.0, 1000.0})) {
    run.sensors.ft.rate = *rate;
    run.sensors.draw_wire.rate = *rate;
  }
  run.seed = static_cast<std::uint64_t>(params.integer("seed", 1, 0, 1 << 30));

  rig::RunConditions& conditions = run.conditions;
  conditions.slip = params.number("slip", 0.3, {-1.0, 1.0});
  conditions.load = params.number("load", 42.1, yaml::positive());
  conditions.wheel_speed = params.number("wheel_speed", conditions.wheel_speed, yaml::positive());
  conditions.steering_angle =
      params.number("steering_angle", 0.0, {-run.rig.steering_limit, run.rig.steering_limit});
  conditions.towed = params.boolean("towed", false);
  conditions.temperature = params.number("temperature", conditions.temperature, {-50.0, 100.0});
  run.profile.travel = params.number("travel", run.profile.travel, {0.0, run.rig.carriage.stroke});
  run.profile.longest_steady = params.number("longest_steady", run.profile.longest_steady, yaml::positive());
  setup.title = fmt::format("{} on {}\n{} soil", setup.wheel.name, setup.soil.name,
                            setup.dem ? "discrete-element" : "semi-empirical");
  std::replace(setup.title.begin(), setup.title.end(), '_', ' ');
  return setup;
}

void take_twin(RigSetup& setup, const std::string& path) {
  setup.twin = twin::read_twin(path);
  setup.wheel = setup.twin->wheel;
  setup.soil = setup.twin->soil;
  setup.run.radius = setup.wheel.radius;
  setup.run.rig.mount.arm_z = setup.twin->rig.mount.arm_z;
  setup.run.rig.mount.drive_torque_share = setup.twin->rig.mount.drive_torque_share;
  setup.run.rig.drive.coulomb_loss = setup.twin->rig.drive.coulomb_loss;
  setup.title = setup.twin->name + "\nrevised twin";
  std::replace(setup.title.begin(), setup.title.end(), '_', ' ');
}

std::unique_ptr<rig::Contact> make_contact(const RigSetup& setup, const rig::Ports& ports) {
  return twin::make_contact("semi_empirical", setup.wheel, setup.soil, ports);
}

}  // namespace wheel_twin::nodes
