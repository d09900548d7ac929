#include "rig/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "../message_of.h"
#include "test_contact.h"

namespace wheel_twin::rig {
namespace {

constexpr double radius = 0.09;

RunConditions conditions(double slip = 0.3, double load = 42.1) {
  RunConditions set;
  set.slip = slip;
  set.load = load;
  return set;
}

/// Runs at the speeds of the conditions until everything has settled.
const RigStep& settled(Rig& rig, const RunConditions& set, double seconds = 1.0) {
  const Speeds speeds = speeds_of_slip(set.slip, set.wheel_speed, radius);
  for (int i = 0; i < static_cast<int>(seconds * 1000.0); ++i)
    rig.advance({speeds.carriage, speeds.wheel, {}}, 0.001);
  return rig.step();
}

TEST(Slip, IsThatOfDrivingAndBrakingWheels) {
  EXPECT_DOUBLE_EQ(slip_ratio(0.7, 1.0), 0.3);
  EXPECT_DOUBLE_EQ(slip_ratio(1.0, 0.7), -0.3);
  EXPECT_DOUBLE_EQ(slip_ratio(1.0, 0.0), -1.0);
  EXPECT_DOUBLE_EQ(slip_ratio(0.0, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(slip_ratio(0.0, 0.0), 0.0);
  for (const double slip : {-1.0, -0.4, 0.0, 0.2, 1.0}) {
    const Speeds speeds = speeds_of_slip(slip, 0.3, radius);
    EXPECT_NEAR(slip_ratio(speeds.carriage, radius * speeds.wheel), slip, 1e-15);
  }
}

TEST(Rig, RestsInStaticEquilibrium) {
  TestContact contact;
  Rig rig(plain_rig(), conditions(), radius, contact, {});
  const RigStep& step = rig.start(std::nullopt);
  EXPECT_NEAR(step.state.hub_displacement, 42.1 / contact.stiffness, 1e-8);
  EXPECT_NEAR(step.readings.wrench.force.z(), 42.1, 1e-4);
  EXPECT_EQ(step.readings.wrench.force.x(), 0.0);
  EXPECT_EQ(step.readings.joints.wheel_effort, 0.0);
}

TEST(Rig, DynamicsEndInTheStaticEquilibrium) {
  TestContact contact;
  RigSettings settings = plain_rig();
  settings.slide.viscous_damping = 60.0;
  Rig rig(settings, conditions(), radius, contact, {});
  rig.start(0.0);
  const RigStep& step = settled(rig, conditions(), 5.0);
  EXPECT_NEAR(step.state.hub_displacement, 42.1 / contact.stiffness, 1e-9);
  EXPECT_NEAR(step.state.slip, 0.3, 1e-12);
}

// A known weight, both ways round: standing on the soil it reads +weight; hung on the hub it reads -weight.
TEST(Rig, AKnownWeightReadsAsDocumented) {
  TestContact contact;
  Rig standing(plain_rig(), conditions(0.0, 10.0), radius, contact, {});
  EXPECT_NEAR(standing.start(std::nullopt).readings.wrench.force.z(), +10.0, 1e-5);

  struct HungWeight : Contact {
    HubLoad advance(const HubMotion&) override {
      HubLoad load;
      load.force_hub_rig.z() = -10.0;
      return load;
    }
  } weight;
  RigSettings settings = plain_rig();
  settings.slide.coulomb_friction = 1e3;  // the slide is clamped
  Rig hanging(settings, conditions(), radius, weight, {});
  EXPECT_EQ(hanging.start(-0.05).readings.wrench.force.z(), -10.0);
  EXPECT_EQ(hanging.advance({}, 0.001).readings.wrench.force.z(), -10.0);
}

TEST(Rig, ChannelsHaveTheSignsOfTheArchitecture) {
  TestContact contact;
  RunConditions set = conditions(0.4);
  set.steering_angle = 0.1;
  Rig rig(plain_rig(), set, radius, contact, {});
  rig.start(std::nullopt);
  const Readings& readings = settled(rig, set).readings;
  EXPECT_GT(readings.wrench.force.x(), 0.0);  // drawbar pull of a driving wheel
  EXPECT_GT(readings.wrench.force.y(), 0.0);  // turned to the left, pushed to +y
  EXPECT_GT(readings.wrench.force.z(), 0.0);
  EXPECT_GT(readings.displacement, 0.0);
  EXPECT_GT(readings.joints.wheel_effort, 0.0);
  EXPECT_GT(readings.joints.wheel_rate, 0.0);
  EXPECT_GT(readings.joints.carriage_velocity, 0.0);
  EXPECT_GT(readings.joints.carriage_position, 0.0);
  EXPECT_LT(readings.wrench.torque.y(), 0.0);  // thrust below the sensor pitches it up, about -y
}

// Statics of the tool: a force at the contact patch, `radius` below the hub, has about the sensor the moment
// r x F with r from the sensor to the patch. For this contact the drive torque is radius times the gross
// thrust.
TEST(Rig, SensorTorquesAreTheMomentsOfTheSoilsForce) {
  TestContact contact;
  contact.resistance = 0.0;  // all of the thrust acts at the patch
  RigSettings settings = plain_rig();
  settings.mount.arm_x = 0.02;
  settings.mount.arm_y = -0.01;
  settings.mount.arm_z = 0.16;
  RunConditions set = conditions(0.4);
  Rig rig(settings, set, radius, contact, {});
  rig.start(std::nullopt);
  const WrenchReading& wrench = settled(rig, set).readings.wrench;
  const Eigen::Vector3d hub_to_patch(0.0, 0.0, -radius);
  const Eigen::Vector3d sensor_to_patch = hub_to_patch - Eigen::Vector3d(0.02, -0.01, 0.16);
  const Eigen::Vector3d moment = sensor_to_patch.cross(wrench.force);
  EXPECT_LT((wrench.torque - moment).norm(), 1e-9);

  settings.mount.drive_torque_share = 0.0;  // a torque arm leads the drive torque past the sensor
  Rig freed(settings, set, radius, contact, {});
  freed.start(std::nullopt);
  const RigStep& step = settled(freed, set);
  EXPECT_NEAR(step.readings.wrench.torque.y(), moment.y() + step.load.drive_torque, 1e-9);
}

TEST(Rig, TheSensorFeelsTheInertiaOfTheTool) {
  TestContact contact;
  RigSettings settings = plain_rig();
  settings.mount.tool_mass = 2.0;
  Rig rig(settings, conditions(), radius, contact, {});
  rig.start(-1.0);  // in the air, free to fall
  EXPECT_NEAR(rig.advance({}, 0.001).readings.wrench.force.z(), 2.0 * 9.80665,
              1e-9);  // weightless, and tared
  Rig held(settings, conditions(), radius, contact, {});
  held.start(-1.0);
  Command up_to_speed;
  up_to_speed.carriage_speed = 0.01;
  up_to_speed.lowest_slide_velocity = 0.0;
  EXPECT_NEAR(held.advance(up_to_speed, 0.001).readings.wrench.force.x(), -2.0 * 0.01 / 0.001, 1e-9);
}

TEST(Rig, SpeedControllersLagByTheirTimeConstant) {
  TestContact contact;
  RigSettings settings = plain_rig();
  settings.carriage.speed_lag = 0.05;
  settings.drive.speed_lag = 0.02;
  settings.drive.inertia = 0.06;
  Rig rig(settings, conditions(), radius, contact, {});
  rig.start(-0.01);
  Command command;
  command.carriage_speed = 0.02;
  command.wheel_rate = 0.3;
  command.lowest_slide_velocity = 0.0;
  for (int i = 0; i < 50; ++i) rig.advance(command, 0.001);
  const JointReading& joints = rig.step().readings.joints;
  EXPECT_NEAR(joints.carriage_velocity, 0.02 * (1.0 - std::exp(-1.0)), 1e-12);
  EXPECT_NEAR(joints.carriage_position, 0.02 * (0.05 - 0.05 * (1.0 - std::exp(-1.0))), 1e-12);
  EXPECT_NEAR(joints.wheel_rate, 0.3 * (1.0 - std::exp(-2.5)), 1e-12);
  // Effort of a wheel in the air is its inertia times its acceleration, 0.3/0.02 exp(-t/0.02), over the last
  // step.
  EXPECT_NEAR(joints.wheel_effort, 0.06 * 0.3 / 0.02 * std::exp(-2.475), 1e-3 * 0.06 * 0.3 / 0.02);
}

TEST(Rig, TheBeltGivesWayUnderDrawbarPull) {
  TestContact contact;
  RigSettings settings = plain_rig();
  settings.carriage.belt_stiffness = 2e4;
  Rig rig(settings, conditions(), radius, contact, {});
  rig.start(std::nullopt);
  const RigStep& step = settled(rig, conditions(), 8.0);
  const double pull = step.load.force_hub_rig.x();
  EXPECT_NEAR(step.state.x - step.readings.joints.carriage_position, pull / 2e4, 1e-9);
  EXPECT_NEAR(pull, 0.5 * 0.3 * 42.1 - 1.0, 1e-4);  // at rest again, it changes nothing else
}

TEST(Rig, ATowedWheelTurnsUntilNoTorqueIsLeft) {
  TestContact contact;
  RunConditions set = conditions();
  set.towed = true;
  for (const bool again : {true, false}) {
    contact.again = again;
    Rig rig(plain_rig(), set, radius, contact, {});
    rig.start(42.1 / contact.stiffness);
    const double dt = again ? 0.001 : 1e-5;
    Command command;
    command.carriage_speed = 0.0257;
    for (double t = 0.0; t < 1.0; t += dt) rig.advance(command, dt);
    const RigStep& step = rig.step();
    EXPECT_NEAR(step.state.slip, 0.0, 1e-6);
    EXPECT_NEAR(step.load.drive_torque, 0.0, 1e-6);
    EXPECT_NEAR(step.readings.wrench.force.x(), -1.0, 1e-5);  // towed: the rolling resistance
    EXPECT_EQ(step.readings.joints.wheel_effort, 0.0);
  }
}

TEST(Rig, BearingFrictionMakesATowedWheelSkid) {
  TestContact contact;
  contact.resistance = 0.0;
  RigSettings settings = plain_rig();
  settings.drive.bearing_friction = 0.2;
  RunConditions set = conditions();
  set.towed = true;
  Rig rig(settings, set, radius, contact, {});
  rig.start(std::nullopt);
  Command command;
  command.carriage_speed = 0.0257;
  for (int i = 0; i < 2000; ++i) rig.advance(command, 0.001);
  // Torque balance: radius * thrust * slip * load = -friction.
  EXPECT_NEAR(rig.step().state.slip, -0.2 / (radius * contact.thrust * 42.1), 1e-5);
}

TEST(Rig, TheSensorWarmsAtTheStatedRate) {
  TestContact contact;
  RunConditions set = conditions();
  set.temperature = 20.0;
  set.temperature_rate = 0.01;
  Rig rig(plain_rig(), set, radius, contact, {});
  EXPECT_EQ(rig.start(std::nullopt).readings.temperature, 20.0);
  EXPECT_NEAR(settled(rig, set, 5.0).readings.temperature, 20.05, 1e-9);
  EXPECT_NEAR(rig.step().state.temperature, 20.05, 1e-9);
}

struct AllRigPorts : RigPort {
  double weight = 0.0, friction = 0.0, factor = 1.0, steering = 0.0, drag = 0.0;
  double added_dead_weight(const RigState&) const override { return weight; }
  double coulomb_friction(const RigState&) const override { return friction; }
  double speed_factor(const RigState&) const override { return factor; }
  double added_steering(const RigState&) const override { return steering; }
  double motor_drag(const RigState&) const override { return drag; }
};

TEST(RigPorts, ActWhereTheySay) {
  TestContact contact;
  AllRigPorts port;
  port.weight = 3.0;
  port.factor = 0.94;
  port.steering = 0.05;
  port.drag = 0.1;
  Ports ports;
  ports.rig.push_back(&port);
  Rig rig(plain_rig(), conditions(0.2), radius, contact, ports);
  rig.start(std::nullopt);
  const RigStep& step = settled(rig, conditions(0.2));
  EXPECT_NEAR(step.readings.wrench.force.z(), 45.1, 1e-4);
  EXPECT_NEAR(step.state.slip, 1.0 - 0.8 * 0.94, 1e-12);  // true slip
  EXPECT_NEAR(step.state.carriage_speed, 0.94 * step.readings.joints.carriage_velocity, 1e-15);
  EXPECT_NEAR(step.state.x, 0.94 * step.readings.joints.carriage_position, 1e-12);
  EXPECT_NEAR(contact.last.steering_angle, 0.05, 1e-15);
  EXPECT_EQ(step.state.steering_angle, 0.0);
  EXPECT_NEAR(step.readings.joints.wheel_effort - step.load.drive_torque, 0.1, 1e-12);
  EXPECT_GT(step.readings.wrench.force.y(), 0.0);
}

TEST(RigPorts, SlideFrictionHoldsTheWheelOffItsEquilibrium) {
  TestContact contact;
  AllRigPorts port;
  port.friction = 3.5;
  Ports ports;
  ports.rig.push_back(&port);
  RigSettings settings = plain_rig();
  settings.slide.viscous_damping = 400.0;
  Rig rig(settings, conditions(), radius, contact, ports);
  rig.start(0.0);
  const RigStep& step = settled(rig, conditions(), 3.0);
  // Overdamped and coming from above, the slide creeps to where friction is spent.
  EXPECT_NEAR(step.state.slide_velocity, 0.0, 1e-12);
  EXPECT_NEAR(step.readings.wrench.force.z(), 42.1 - 3.5, 1e-9);
  EXPECT_NEAR(step.friction, 3.5, 1e-9);
}

struct AllSensorPorts : SensorPort {
  void change_wrench(const RigState& state, WrenchReading& reading) const override {
    reading.force.x() += 1.0 + 0.5 * state.time;
  }
  void change_displacement(const RigState&, double normal_load, double& displacement) const override {
    displacement += 4e-5 * normal_load;
  }
  void change_motor_effort(const RigState&, double& effort) const override { effort = -effort; }
  double draw_wire_delay() const override { return 0.25; }
};

TEST(SensorPorts, ChangeReadingsAndNothingElse) {
  TestContact contact;
  AllSensorPorts port;
  Ports ports;
  ports.sensor.push_back(&port);
  Rig rig(plain_rig(), conditions(), radius, contact, ports);
  rig.start(std::nullopt);
  const RigStep& step = settled(rig, conditions());
  EXPECT_NEAR(step.readings.wrench.force.x() - step.load.force_hub_rig.x(), 1.0 + 0.5 * step.state.time,
              1e-9);
  EXPECT_NEAR(step.readings.displacement - step.state.hub_displacement, 4e-5 * 42.1, 1e-9);
  EXPECT_NEAR(step.readings.joints.wheel_effort, -step.load.drive_torque, 1e-12);
  EXPECT_EQ(rig.draw_wire_delay(), 0.25);
}

TEST(Rig, RefusesWhatARealRigRefuses) {
  TestContact contact;
  const auto with = [&](const RunConditions& set) {
    return message_of([&] { Rig(plain_rig(), set, radius, contact, {}); });
  };
  RunConditions steered = conditions();
  steered.steering_angle = 0.44;
  EXPECT_THAT(with(steered), testing::HasSubstr("steering angle 25.2 degrees is beyond the limit of 25"));
  EXPECT_THAT(with(conditions(1.2)), testing::HasSubstr("slip 1.2"));
  EXPECT_THAT(with(conditions(0.0, -3.0)), testing::HasSubstr("load"));
  EXPECT_THAT(message_of([&] { Rig(plain_rig(), conditions(), 0.0, contact, {}); }),
              testing::HasSubstr("radius"));

  contact.stiffness = 100.0;
  EXPECT_THAT(message_of([&] { Rig(plain_rig(), conditions(), radius, contact, {}).start(std::nullopt); }),
              testing::HasSubstr("no equilibrium"));
  EXPECT_THAT(message_of([&] {
                Rig rig(plain_rig(), conditions(), radius, contact, {});
                rig.start(0.0);
                settled(rig, conditions());
              }),
              testing::HasSubstr("lower stop"));
  contact.again = false;
  EXPECT_THAT(message_of([&] { Rig(plain_rig(), conditions(), radius, contact, {}).start(std::nullopt); }),
              testing::HasSubstr("evaluated again"));
}

}  // namespace
}  // namespace wheel_twin::rig
