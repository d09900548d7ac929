#include "rig/semi_empirical_contact.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace wheel_twin::rig {
namespace {

using terramechanics::ContactState;
using terramechanics::Soil;
using terramechanics::Wheel;
using terramechanics::WheelOnSoil;

Wheel wheel() {
  Wheel w;
  w.stiffness = 12000.0;
  return w;
}

/// A wheel rolled far enough at a constant height to have forgotten its start.
HubMotion rolling(double displacement, double slip, double steering = 0.0) {
  HubMotion motion;
  motion.time = 100.0;
  motion.wheel_rate = slip >= 0.0 ? 0.3 : 0.3 * (1.0 + slip);
  motion.velocity.x() = slip >= 0.0 ? (1.0 - slip) * 0.3 * 0.09 : 0.3 * 0.09;
  motion.position.x() = motion.velocity.x() * motion.time;
  motion.position.z() = -displacement;
  motion.steering_angle = steering;
  return motion;
}

HubLoad steady(SemiEmpiricalContact& contact, const HubMotion& motion) {
  HubMotion start = motion;
  start.time = 0.0;
  start.position.x() = 0.0;
  contact.advance(start);
  return contact.advance(motion);
}

TEST(SemiEmpiricalContact, SteadyStateIsTheModels) {
  for (const double slip : {-0.9, -0.2, 0.0, 0.3}) {
    SemiEmpiricalContact contact(wheel(), Soil{});
    const HubLoad load = steady(contact, rolling(0.012, slip, 0.1));
    const ContactState state = WheelOnSoil(wheel(), Soil{}).at_hub_displacement(0.012, {slip, 0.1});
    EXPECT_NEAR(load.force_hub_rig.x(), state.drawbar_pull, 1e-6);
    EXPECT_NEAR(load.force_hub_rig.y(), state.side_force, 1e-6);
    EXPECT_NEAR(load.force_hub_rig.z(), state.normal_load, 1e-6);
    EXPECT_NEAR(load.drive_torque, state.drive_torque, 1e-8);
    const Eigen::Vector3d axle(-std::sin(0.1), std::cos(0.1), 0.0);
    EXPECT_NEAR(load.torque_hub_rig.dot(axle), -load.drive_torque, 1e-12);
    EXPECT_GT(load.vertical_stiffness, 0.0);
  }
}

TEST(SemiEmpiricalContact, RestsOnItsStaticSinkageAndPassesIntoRolling) {
  SemiEmpiricalContact contact(wheel(), Soil{});
  HubMotion motion;
  motion.position.z() = -0.01;
  const HubLoad rest = contact.advance(motion);
  const WheelOnSoil model(wheel(), Soil{});
  EXPECT_NEAR(rest.force_hub_rig.z(), model.at_rest_at_hub_displacement(0.01).normal_load, 1e-9);
  EXPECT_EQ(rest.force_hub_rig.x(), 0.0);
  EXPECT_EQ(rest.drive_torque, 0.0);
  double previous = 0.0;
  for (int i = 1; i <= 6000; ++i) {
    motion.time = 0.001 * i;
    motion.wheel_rate = 0.3;
    motion.velocity.x() = 0.5 * 0.027;
    motion.position.x() += 0.001 * motion.velocity.x();
    const double pull = contact.advance(motion).force_hub_rig.x();
    EXPECT_GE(pull, previous - 1e-9);  // builds up without a jump
    EXPECT_LT(pull - previous, 0.05);
    previous = pull;
  }
  EXPECT_NEAR(previous, model.at_hub_displacement(0.01, {0.5, 0.0}).drawbar_pull, 0.01 * previous);
}

TEST(SemiEmpiricalContact, RepeatedTimeEvaluatesAnew) {
  SemiEmpiricalContact a(wheel(), Soil{}), b(wheel(), Soil{});
  HubMotion motion = rolling(0.01, 0.3);
  motion.time = 0.0;
  a.advance(motion);
  b.advance(motion);
  motion.time = 0.1;
  HubMotion other = motion;
  other.position.z() = -0.02;
  b.advance(other);
  b.advance(other);
  // Guesses differ, results only by the solver's tolerance.
  EXPECT_NEAR(a.advance(motion).force_hub_rig.x(), b.advance(motion).force_hub_rig.x(), 1e-6);
  motion.time = 0.05;
  EXPECT_THAT([&] { a.advance(motion); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("time goes back")));
}

TEST(SemiEmpiricalContact, BackwardsMirrorsForwards) {
  SemiEmpiricalContact forth(wheel(), Soil{}), back(wheel(), Soil{});
  HubMotion motion = rolling(0.012, 0.3);
  const HubLoad a = steady(forth, motion);
  motion.velocity.x() *= -1.0;
  motion.position.x() *= -1.0;
  motion.wheel_rate *= -1.0;
  const HubLoad b = steady(back, motion);
  EXPECT_DOUBLE_EQ(a.force_hub_rig.x(), -b.force_hub_rig.x());
  EXPECT_DOUBLE_EQ(a.force_hub_rig.z(), b.force_hub_rig.z());
  EXPECT_DOUBLE_EQ(a.drive_torque, -b.drive_torque);
}

TEST(SemiEmpiricalContact, IndentationIsResistedAndReboundIsNot) {
  SemiEmpiricalContact contact(wheel(), Soil{});
  HubMotion motion = rolling(0.012, 0.3);
  const double still = steady(contact, motion).force_hub_rig.z();
  motion.velocity.z() = -0.01;
  EXPECT_NEAR(contact.advance(motion).force_hub_rig.z(), 1.1 * still, 1e-6);
  motion.velocity.z() = 0.01;
  EXPECT_NEAR(contact.advance(motion).force_hub_rig.z(), 0.9 * still, 1e-6);
  motion.velocity.z() = 10.0;
  EXPECT_EQ(contact.advance(motion).force_hub_rig.z(), 0.0);
}

struct Everything final : SoilPort, WheelPort {
  double factor = 1.0, cohesion = 0.0, sinkage = 1.0, slope = 0.0, rise = 0.0, resistance = 0.0;
  Eigen::Vector3d force{0.0, 0.0, 0.0};
  double stiffness_factor(const RigState&) const override { return factor; }
  double added_cohesion(const RigState&) const override { return cohesion; }
  double sinkage_factor(const RigState&) const override { return sinkage; }
  Eigen::Vector3d added_force(const RigState&, double) const override { return force; }
  double surface_slope(const RigState&) const override { return slope; }
  double hub_rise(const RigState&) const override { return rise; }
  double rolling_resistance(const RigState&) const override { return resistance; }
};

class Ported : public testing::Test {
 protected:
  HubLoad load(double displacement = 0.012) {
    Ports ports;
    ports.soil = {&port_};
    ports.wheel = {&port_};
    SemiEmpiricalContact contact(wheel(), Soil{}, ports);
    return steady(contact, rolling(displacement, 0.3));
  }
  HubLoad plain(double displacement = 0.012, const Soil& soil = {}) {
    SemiEmpiricalContact contact(wheel(), soil);
    return steady(contact, rolling(displacement, 0.3));
  }
  Everything port_;
};

TEST_F(Ported, NeutralPortsChangeNothing) {
  EXPECT_NEAR((load().force_hub_rig - plain().force_hub_rig).norm(), 0.0, 1e-9);
}

TEST_F(Ported, StiffnessAndCohesionAreTheSoils) {
  Soil soil;
  soil.k_c *= 1.5;
  soil.k_phi *= 1.5;
  soil.c = 700.0;
  port_.factor = 1.5;
  port_.cohesion = 700.0;
  EXPECT_NEAR((load().force_hub_rig - plain(0.012, soil).force_hub_rig).norm(), 0.0, 1e-6);
}

TEST_F(Ported, HubRiseIsDisplacement) {
  port_.rise = 0.001;
  EXPECT_NEAR((load(0.011).force_hub_rig - plain(0.012).force_hub_rig).norm(), 0.0, 1e-9);
}

TEST_F(Ported, SinkageFactorDeepensTheSameLoad) {
  const HubLoad firm = plain(0.012);
  const double deflection = firm.force_hub_rig.z() / *wheel().stiffness;
  port_.sinkage = 1.3;
  const HubLoad deep = load(deflection + 1.3 * (0.012 - deflection));
  EXPECT_NEAR(deep.force_hub_rig.z(), firm.force_hub_rig.z(), 1e-6);
  EXPECT_GT(deep.drive_torque, firm.drive_torque);
}

TEST_F(Ported, ResistanceAndAddedForceAddUp) {
  port_.resistance = 2.2;
  port_.force = {-1.0, 0.5, 3.0};
  EXPECT_NEAR((load().force_hub_rig - plain().force_hub_rig - Eigen::Vector3d(-3.2, 0.5, 3.0)).norm(), 0.0,
              1e-9);
}

TEST_F(Ported, SlopeLiftsTheBedAndTurnsTheForce) {
  constexpr double kSlope = 0.02;
  port_.slope = kSlope;
  Ports ports;
  ports.soil = {&port_};
  SemiEmpiricalContact contact(wheel(), Soil{}, ports, {0.0});
  HubMotion motion = rolling(0.012, 0.3);
  motion.position.z() = std::tan(kSlope) * motion.position.x() - 0.012 / std::cos(kSlope);
  steady(contact, motion);  // touches only where the bed has risen to it
  motion.time += 100.0;
  const Eigen::Vector3d tilted = contact.advance(motion).force_hub_rig, flat = plain(0.012).force_hub_rig;
  EXPECT_NEAR(tilted.x(), flat.x() * std::cos(kSlope) - flat.z() * std::sin(kSlope), 1e-6);
  EXPECT_NEAR(tilted.z(), flat.x() * std::sin(kSlope) + flat.z() * std::cos(kSlope), 1e-6);
}

TEST(SemiEmpiricalContact, HubBelowTheSoilIsAnError) {
  SemiEmpiricalContact contact(wheel(), Soil{});
  EXPECT_THAT([&] { contact.advance(rolling(0.095, 0.3)); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("below its height")));
}

}  // namespace
}  // namespace wheel_twin::rig
