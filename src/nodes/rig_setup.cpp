#include "nodes/rig_setup.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/config_path.h"
#include "base/error.h"
#include "rig/semi_empirical_contact.h"

namespace wheel_twin::nodes {
namespace {

yaml::Map config(const std::string& kind, const std::string& name) {
  return yaml::parse_file(find_config(kind, name));
}

}  // namespace

RigSetup read_rig_setup(Params& params) {
  RigSetup setup;
  setup.wheel = terramechanics::read_wheel(config("wheels", params.text("wheel", "amalia")));
  setup.soil = terramechanics::read_soil(config("soils", params.text("soil", "mars_simulant")));
  setup.fidelity = params.choice("fidelity", "semi_empirical", {"dem", "semi_empirical"});

  rig::RunSettings& run = setup.run;
  run.radius = setup.wheel.radius;
  run.rig = rig::read_rig(config("rigs", params.text("rig", "polito")));
  run.sensors.ft = rig::read_ft(config("sensors", params.text("ft_sensor", "ati_mini45_si_145_5")));
  run.sensors.draw_wire =
      rig::read_draw_wire(config("sensors", params.text("draw_wire", "micro_epsilon_draw_wire")));
  run.sensors.joints = rig::read_joints(config("sensors", params.text("joints", "motor_joints")));
  run.sensors.temperature =
      rig::read_temperature(config("sensors", params.text("thermometer", "thermometer")));
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
                            setup.fidelity == "dem" ? "discrete-element" : "semi-empirical");
  std::replace(setup.title.begin(), setup.title.end(), '_', ' ');
  return setup;
}

std::unique_ptr<rig::Contact> make_contact(const RigSetup& setup) {
  if (setup.fidelity == "semi_empirical")
    return std::make_unique<rig::SemiEmpiricalContact>(setup.wheel, setup.soil);
  throw Error(fmt::format("fidelity: '{}' is not available live", setup.fidelity));
}

}  // namespace wheel_twin::nodes
