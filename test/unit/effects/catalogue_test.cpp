// Every effect against the definition of its parameters in the catalogue, through the ports that it
// implements.
#include "effects/catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/error.h"

namespace wheel_twin::effects {
namespace {

using testing::HasSubstr;

rig::RigState some_state() {
  rig::RigState state;
  state.time = 20.0;
  state.x = 0.3;
  state.carriage_speed = 0.015;
  state.wheel_angle = 2.5;
  state.wheel_rate = 0.28;
  state.rim_travel = 0.5;
  state.slip = 0.4;
  state.hub_displacement = 0.02;
  state.temperature = 24.0;
  return state;
}

/// Everything that one effect can change, asked at one state.
struct Response {
  double stiffness, cohesion, sinkage, slope, rise, resistance, weight, friction, speed, steering, drag,
      delay;
  double displacement = 0.02;
  Eigen::Vector3d added_force;
  rig::WrenchReading wrench{{5.0, -1.0, 42.0}, {0.1, -0.8, 0.05}};
};

Response respond(const std::string& name, const std::vector<double>& values,
                 const rig::RigState& state = some_state()) {
  const auto effect = make_effect(find_effect(name), values);
  rig::Ports ports;
  effect->attach(ports);
  EXPECT_EQ(ports.soil.size() + ports.wheel.size() + ports.rig.size() + ports.sensor.size(), 1u) << name;
  const rig::SoilPort no_soil;
  const rig::WheelPort no_wheel;
  const rig::RigPort no_rig;
  const rig::SensorPort no_sensor;
  const rig::SoilPort& soil = ports.soil.empty() ? no_soil : *ports.soil[0];
  const rig::WheelPort& wheel = ports.wheel.empty() ? no_wheel : *ports.wheel[0];
  const rig::RigPort& rig = ports.rig.empty() ? no_rig : *ports.rig[0];
  const rig::SensorPort& sensor = ports.sensor.empty() ? no_sensor : *ports.sensor[0];
  Response r{};
  r.displacement = 0.02;
  r.wrench = {{5.0, -1.0, 42.0}, {0.1, -0.8, 0.05}};
  r.stiffness = soil.stiffness_factor(state) * soil.layer_factor(state, 0.015);
  r.cohesion = soil.added_cohesion(state);
  r.sinkage = soil.sinkage_factor(state);
  r.slope = soil.surface_slope(state);
  r.added_force = soil.added_force(state, 42.0);
  r.rise = wheel.hub_rise(state);
  r.resistance = wheel.rolling_resistance(state);
  r.weight = rig.added_dead_weight(state);
  r.friction = rig.coulomb_friction(state);
  r.speed = rig.speed_factor(state);
  r.steering = rig.added_steering(state);
  r.drag = rig.motor_drag(state);
  r.delay = sensor.draw_wire_delay();
  sensor.change_wrench(state, r.wrench);
  sensor.change_displacement(state, 42.0, r.displacement);
  return r;
}

/// Sum of all departures from "nothing acts", each in units of what matters.
double departure(const Response& r) {
  const Eigen::Vector3d force(5.0, -1.0, 42.0);
  const Eigen::Vector3d torque(0.1, -0.8, 0.05);
  return std::abs(r.stiffness - 1) + r.cohesion / 500 + std::abs(r.sinkage - 1) + std::abs(r.slope) +
         r.added_force.norm() + 1e3 * std::abs(r.rise) + r.resistance + std::abs(r.weight) + r.friction +
         std::abs(r.speed - 1) + std::abs(r.steering) + r.drag + std::abs(r.delay) +
         (r.wrench.force - force).norm() + (r.wrench.torque - torque).norm() +
         1e3 * std::abs(r.displacement - 0.02);
}

TEST(Catalogue, NamesAndParametersAreThoseOfTheInterface) {
  const std::vector<std::string> names = {"ft_bias",
                                          "ft_drift",
                                          "ft_thermal",
                                          "ft_misalignment",
                                          "ft_gain",
                                          "ft_crosstalk",
                                          "draw_wire_offset",
                                          "draw_wire_scale",
                                          "clock_skew",
                                          "carriage_speed_error",
                                          "dead_weight_error",
                                          "slide_friction",
                                          "rig_compliance",
                                          "bed_tilt",
                                          "steering_misalignment",
                                          "motor_drag",
                                          "wheel_eccentricity",
                                          "soft_spoke",
                                          "wheel_flexing_resistance",
                                          "slip_sinkage",
                                          "soil_cohesion",
                                          "density_gradient",
                                          "multi_pass",
                                          "hard_layer",
                                          "buried_rock"};
  std::set<std::string> known;
  for (const EffectType& type : catalogue()) known.insert(type.name);
  EXPECT_EQ(known.size(), catalogue().size()) << "a name stands twice";
  for (const std::string& name : names) EXPECT_EQ(known.count(name), 1u) << name;
  EXPECT_EQ(find_effect("buried_rock").parameters[1].name, "half_width");
}

TEST(Catalogue, NeutralParametersChangeNothingAndOneScaleChangesSomething) {
  rig::RigState state = some_state();
  state.wheel_angle = -0.2;  // where a soft spoke with the phase below is under the hub
  for (const EffectType& type : catalogue()) {
    std::vector<double> neutral, one_scale;
    for (const Parameter& p : type.parameters) {
      EXPECT_LT(p.lower, p.upper) << type.name;
      EXPECT_GT(p.scale, 0.0) << type.name;
      const bool shape = std::isnan(p.neutral);
      const double inside = 0.3;  // a position, phase or length within the bounds of every shape parameter
      neutral.push_back(shape ? inside : p.neutral);
      const bool upwards = p.neutral + p.scale <= p.upper;
      one_scale.push_back(shape ? inside : p.neutral + (upwards ? p.scale : -0.95 * p.neutral));
    }
    rig::RigState braking = state;  // some effects act on a driven wheel, some on a braked one
    braking.slip = -0.4;
    const auto both = [&](const std::vector<double>& values) {
      return departure(respond(type.name, values, state)) + departure(respond(type.name, values, braking));
    };
    EXPECT_LT(both(neutral), 2e-4) << type.name;
    EXPECT_GT(both(one_scale), 1e-3) << type.name;
  }
}

TEST(Catalogue, RefusesWhatIsOutOfBoundsOrUnknown) {
  EXPECT_THROW(make_effect(find_effect("slide_friction"), {-1.0}), Error);
  EXPECT_THROW(make_effect(find_effect("slide_friction"), {std::nan("")}), Error);
  EXPECT_THROW(make_effect(find_effect("slide_friction"), {1.0, 2.0}), Error);
  try {
    find_effect("slide_fiction");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("slide_friction"));
  }
}

TEST(SensorEffects, FollowTheirDefinitions) {
  EXPECT_TRUE(respond("ft_bias", {1, 2, 3}).wrench.force.isApprox(Eigen::Vector3d(6, 1, 45)));
  EXPECT_TRUE(respond("ft_drift", {0.1, 0, -0.1}).wrench.force.isApprox(Eigen::Vector3d(7, -1, 40)));
  EXPECT_TRUE(respond("ft_thermal", {1, 0, 2}).wrench.force.isApprox(Eigen::Vector3d(7, -1, 46)));
  EXPECT_TRUE(respond("ft_gain", {0.1, 0, -0.5}).wrench.force.isApprox(Eigen::Vector3d(5.5, -1, 21)));
  EXPECT_NEAR(respond("ft_crosstalk", {2.0}).wrench.force.x(), 5.0 - 1.6, 1e-12);
  EXPECT_NEAR(respond("draw_wire_offset", {0.002}).displacement, 0.022, 1e-12);
  EXPECT_NEAR(respond("draw_wire_scale", {0.1}).displacement, 0.022, 1e-12);
  EXPECT_NEAR(respond("draw_wire_drift", {1e-4}).displacement, 0.022, 1e-12);
  EXPECT_NEAR(respond("clock_skew", {-0.2}).delay, -0.2, 1e-12);
  EXPECT_NEAR(respond("rig_compliance", {1e-4}).displacement, 0.02 + 42e-4, 1e-12);
}

TEST(SensorEffects, MisalignmentTurnsAboutYThenX) {
  // Ry(p) v = (x cos p + z sin p, y, -x sin p + z cos p); Rx(r) v = (x, y cos r - z sin r, y sin r + z cos
  // r).
  const double p = 0.1;
  const Eigen::Vector3d pitched = respond("ft_misalignment", {p, 0.0}).wrench.force;
  EXPECT_NEAR(pitched.x(), 5 * std::cos(p) + 42 * std::sin(p), 1e-12);
  EXPECT_NEAR(pitched.z(), -5 * std::sin(p) + 42 * std::cos(p), 1e-12);
  const Eigen::Vector3d rolled = respond("ft_misalignment", {0.0, p}).wrench.force;
  EXPECT_NEAR(rolled.y(), -std::cos(p) - 42 * std::sin(p), 1e-12);
  EXPECT_NEAR(rolled.z(), -std::sin(p) + 42 * std::cos(p), 1e-12);
}

TEST(WheelEffects, ComeBackWithEveryTurn) {
  const rig::RigState state = some_state();
  rig::RigState turn_later = state;
  turn_later.wheel_angle += 2.0 * std::acos(-1.0);
  EXPECT_NEAR(respond("wheel_eccentricity", {0.001, 0.8}).rise, 0.001 * std::cos(3.3), 1e-15);
  for (const auto& [name, values] :
       {std::pair<std::string, std::vector<double>>{"wheel_eccentricity", {0.001, 0.8}},
        {"soft_spoke", {0.001, 0.3, -2.0}}})
    EXPECT_NEAR(respond(name, values, state).rise, respond(name, values, turn_later).rise, 1e-12) << name;
  rig::RigState at_spoke = state;
  at_spoke.wheel_angle = 2.0;
  EXPECT_NEAR(respond("soft_spoke", {0.001, 0.3, -2.0}, at_spoke).rise, -0.001, 1e-15);
  at_spoke.wheel_angle = 2.3;
  EXPECT_NEAR(respond("soft_spoke", {0.001, 0.3, -2.0}, at_spoke).rise, -0.001 * std::exp(-0.5), 1e-12);
}

TEST(SoilEffects, FollowTheirDefinitions) {
  EXPECT_NEAR(respond("slip_sinkage", {0.5, 0.1}).sinkage, 1 + 0.5 * 0.4 * (1 - std::exp(-5.0)), 1e-12);
  EXPECT_NEAR(respond("density_gradient", {0.5}).stiffness, 1.15, 1e-12);
  EXPECT_NEAR(respond("multi_pass", {0.5}).stiffness, 1.5, 1e-12);
  EXPECT_NEAR(respond("hard_layer", {0.03}).stiffness, 1.125, 1e-12);
  EXPECT_NEAR(respond("bed_tilt", {0.02}).slope, 0.02, 1e-15);
  EXPECT_NEAR(respond("soil_cohesion", {900}).cohesion, 900, 1e-12);
}

TEST(SoilEffects, RockResistsOnItsRiseAndPushesOnItsFallAsFarAsItIsClimbed) {
  const std::vector<double> climbed = {0.3, 0.02, 1.5, 1.0, 0.0}, passed = {0.3, 0.02, 1.5, 0.0, 6.0};
  EXPECT_NEAR(respond("buried_rock", climbed).stiffness, 2.5, 1e-12);
  rig::RigState before = some_state();
  before.x = 0.28;
  rig::RigState after = before;
  after.x = 0.32;
  EXPECT_LT(respond("buried_rock", climbed, before).added_force.x(), 0.0);
  EXPECT_GT(respond("buried_rock", climbed, after).added_force.x(), 0.0);
  EXPECT_NEAR(respond("buried_rock", climbed).added_force.x(), 0.0, 1e-12);
  EXPECT_NEAR(respond("buried_rock", passed).added_force.x(), -6.0, 1e-12);
  EXPECT_NEAR(respond("buried_rock", passed, before).added_force.x(), -6.0 * std::exp(-0.5), 1e-12);
  EXPECT_NEAR(respond("buried_rock", passed, after).added_force.x(), -6.0 * std::exp(-0.5), 1e-12);
}

TEST(SlipLoosening, StiffnessFallsWithSlipOfBothSigns) {
  const auto stiffness = [](double slip, double shape) {
    rig::RigState state = some_state();
    state.slip = slip;
    return respond("slip_loosening", {2.0, shape, 8.0}, state).stiffness;
  };
  EXPECT_DOUBLE_EQ(stiffness(0.0, 1.0), 1.0);
  EXPECT_NEAR(stiffness(0.5, 1.0), 1.0 / (1.0 + 2.0 * 0.5), 1e-12);            // linear
  EXPECT_NEAR(stiffness(0.5, 0.0), 1.0 / (1.0 + 2.0 * std::log(2.0)), 1e-12);  // digging
  EXPECT_NEAR(stiffness(0.5, 1e-5), stiffness(0.5, 0.0), 1e-4);                // continuous in the shape
  EXPECT_NEAR(stiffness(0.5, 2.0), 1.0 / (1.0 + 2.0 * (0.5 - 0.125)), 1e-12);  // s - s^2/2
  EXPECT_NEAR(stiffness(-0.49, 1.0), 1.0 / (1.0 + 8.0 * std::pow(0.7, 5.0)), 1e-12);
  EXPECT_GT(stiffness(1.0, -1.0), 0.0) << "a wheel on the spot";
}

TEST(Bulldozing, PushesABrakedWheelBackByTheSquareOfItsDepth) {
  rig::RigState state = some_state();
  EXPECT_EQ(respond("bulldozing", {8000.0}, state).added_force.norm(), 0.0) << "driving";
  state.slip = -0.25;
  state.hub_displacement = 0.03;
  const Eigen::Vector3d force = respond("bulldozing", {8000.0}, state).added_force;
  EXPECT_NEAR(force.x(), -8000.0 * 0.0009 * 0.5, 1e-12);
  state.hub_displacement = -0.03;
  EXPECT_EQ(respond("bulldozing", {8000.0}, state).added_force.norm(), 0.0) << "above the soil";
}

}  // namespace
}  // namespace wheel_twin::effects
