#include "wheel/flexible_wheel.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.h"
#include "wheel/rigid_floor.h"
#include "wheel/wheel_builder.h"

namespace wheel_twin::wheel {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

WheelModel wheel_file(const std::string& name) {
  return read_wheel_file(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels/" + name + ".yaml");
}

std::string message_of_step(FlexibleWheel& wheel, double dt) {
  try {
    wheel.step(dt, wheel.hub());
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(FlexibleWheel, SegmentAxesAndVelocitiesOfATurnedWheel) {
  FlexibleWheel wheel(wheel_file("amalia"));
  HubMotion hub;
  hub.position = {1.0, 2.0, 0.5};
  hub.velocity = {0.1, 0.0, 0.0};
  hub.angle = M_PI / 2;  // segment 0 has rolled from the top to the front
  hub.rate = 3.0;
  wheel.place(hub);
  const double r = 0.09 * std::cos(M_PI / 64);
  const SegmentState front = wheel.segment(0);
  EXPECT_LT((front.position - Vector3d(1.0 + r, 2.0, 0.5)).norm(), 1e-15);
  EXPECT_LT((front.velocity - Vector3d(0.1, 0.0, -3.0 * r)).norm(), 1e-15);
  EXPECT_LT((front.orientation * Vector3d::UnitZ() - Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_LT((front.orientation * Vector3d::UnitX() + Vector3d::UnitZ()).norm(), 1e-15);
  EXPECT_LT((front.angular_velocity - Vector3d(0.0, 3.0, 0.0)).norm(), 1e-15);
  hub.steering = M_PI / 2;  // heading +y
  wheel.place(hub);
  EXPECT_LT((wheel.segment(0).position - Vector3d(1.0, 2.0 + r, 0.5)).norm(), 1e-15);
  EXPECT_LT((wheel.segment(0).orientation * Vector3d::UnitZ() - Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_LT((wheel.segment(0).angular_velocity - Vector3d(-3.0, 0.0, 0.0)).norm(), 1e-15);
}

// At rest the hub must be held against just what acts on the rim, whatever hangs in between.
TEST(FlexibleWheel, StaticReactionIsTheAppliedWrench) {
  for (const std::string name : {"amalia", "t0_r0"}) {
    FlexibleWheel wheel(wheel_file(name));
    HubMotion hub;
    hub.position = {0.3, -0.2, 0.2};
    hub.steering = 0.2;
    hub.angle = 0.4;
    wheel.place(hub);
    wheel.set_gravity(9.81);
    const Vector3d force{0.5, 1.0, 2.0}, torque{0.01, 0.02, -0.03};
    const Vector3d weight{0.0, 0.0, -9.81 * wheel.rim_mass()};
    wheel.relax(wheel.stable_step(), 300.0, 1e-8, 200000,
                [&](FlexibleWheel& w) { w.apply(11, force, torque); });
    const Vector3d arm = wheel.segment(11).position - hub.position;
    const Wrench reaction = wheel.reaction();
    EXPECT_LT((reaction.force - force - weight).norm(), 1e-5) << name;
    // The weight acts at the deformed rim's centre of mass, on the hub's vertical to within the deflection.
    EXPECT_LT((reaction.torque - arm.cross(force) - torque).norm(), 2e-2) << name;
    wheel.set_gravity(0.0);
    wheel.relax(wheel.stable_step(), 300.0, 1e-8, 200000,
                [&](FlexibleWheel& w) { w.apply(11, force, torque); });
    const Vector3d arm_now = wheel.segment(11).position - hub.position;
    EXPECT_LT((wheel.reaction().torque - arm_now.cross(force) - torque).norm(), 1e-6) << name;
  }
}

TEST(FlexibleWheel, RigidWheelPassesForcesThrough) {
  WheelModel model = wheel_file("amalia");
  model.suspension = Suspension::rigid;
  FlexibleWheel wheel(model);
  HubMotion hub;
  wheel.place(hub);
  const Vector3d force{3.0, 1.0, 2.0};
  const Vector3d point = wheel.segment(20).position + Vector3d(0.01, 0.02, -0.01);
  wheel.apply_at(20, force, point);
  wheel.step(1e-4, hub);
  EXPECT_LT((wheel.reaction().force - force).norm(), 1e-12);
  EXPECT_LT((wheel.reaction().torque - point.cross(force)).norm(), 1e-12);
}

TEST(FlexibleWheel, ForceThatIsNotFiniteNamesStepAndSegment) {
  FlexibleWheel wheel(wheel_file("amalia"));
  for (int i = 0; i < 3; ++i) wheel.step(1e-5, wheel.hub());
  wheel.apply(17, {0.0, std::nan(""), 0.0}, Vector3d::Zero());
  EXPECT_THAT(message_of_step(wheel, 1e-5), HasSubstr("step 3: the force on segment 17 is not finite"));
}

TEST(FlexibleWheel, TorqueThatIsNotFiniteNamesStepAndSegment) {
  FlexibleWheel wheel(wheel_file("t0_r0"));
  wheel.apply_at(63, {0.0, 0.0, 1.0}, {0.0, HUGE_VAL, 0.0});
  EXPECT_THAT(message_of_step(wheel, 1e-6), HasSubstr("step 0: the force on segment 63 is not finite"));
}

TEST(FlexibleWheel, StepBeyondTheStabilityLimitNamesIt) {
  FlexibleWheel wheel(wheel_file("amalia"));
  const std::string message = message_of_step(wheel, 4.1 * wheel.stable_step());
  EXPECT_THAT(message,
              HasSubstr(fmt::format("beyond the stability limit of {:.4g} s", 4.0 * wheel.stable_step())));
  EXPECT_EQ(message_of_step(wheel, 3.9 * wheel.stable_step()), "");
}

// stable_step() keeps 10 % below the limit: there a blow rings on, 10 % above the limit it bursts.
TEST(FlexibleWheel, StabilityLimitIsTheRealOne) {
  for (const double damping : {0.0, 0.02}) {
    WheelModel model = wheel_file("amalia");
    model.damping_ratio = damping;
    const double limit = FlexibleWheel(model).stable_step() / 0.9;
    const auto growth = [&](double dt) {
      PlanarSystem system(build(model).parts);
      system.external(3) = {{0.0, 1e-3}, 1e-6};
      system.step(dt, {});
      system.clear_external();
      const double start = system.kinetic_energy() + system.elastic_energy();
      for (int i = 0; i < 1000; ++i) {
        system.step(dt, {});
        if (system.kinetic_energy() > 1e3 * start) return 1e3;
      }
      return (system.kinetic_energy() + system.elastic_energy()) / start;
    };
    EXPECT_LT(growth(0.9 * limit), 2.0) << "damping ratio " << damping;
    EXPECT_GT(growth(1.1 * limit), 100.0) << "damping ratio " << damping;
  }
}

TEST(FlexibleWheel, RestoredStateContinuesWithTheSameBits) {
  for (const std::string name : {"amalia", "t0_r0"}) {
    FlexibleWheel wheel(wheel_file(name));
    HubMotion hub;
    hub.position.z() = 0.12;
    hub.rate = 5.0;
    wheel.place(hub);
    wheel.set_freedom({true, true, true});
    wheel.set_gravity(9.81);
    const auto run = [&](FlexibleWheel& w, int steps) {
      for (int i = 0; i < steps; ++i) {
        w.apply(9, {0.1 * i, 0.2, 3.0}, {0.0, 0.01, 0.0});
        w.step(1e-5, hub);
      }
    };
    run(wheel, 50);
    const std::vector<double> state = wheel.save();
    run(wheel, 50);
    FlexibleWheel other(wheel_file(name));
    other.restore(state);
    EXPECT_EQ(other.save(), state);
    run(other, 50);
    EXPECT_EQ(other.save(), wheel.save()) << name;
    EXPECT_EQ(other.steps(), 100);
    EXPECT_THROW(other.restore(std::vector<double>(5)), Error);
  }
}

TEST(FlexibleWheel, BeamsRunFromHubToRim) {
  FlexibleWheel wheel(wheel_file("t0_r0"));
  HubMotion hub;
  hub.position = {0.5, 0.0, 0.13};
  wheel.place(hub);
  const auto beams = wheel.beams();
  ASSERT_EQ(beams.size(), 32u);
  for (const BeamState& beam : beams) {
    ASSERT_EQ(beam.points.size(), 13u);
    ASSERT_EQ(beam.bending.size(), 13u);
    const Vector3d centre(0.5, beam.points[0].y(), 0.13);
    EXPECT_NEAR((beam.points.front() - centre).norm(), 0.05, 1e-12);
    EXPECT_NEAR((beam.points.back() - centre).norm(), 0.13 * std::cos(M_PI / 64), 1e-12);
    for (const double angle : beam.bending) EXPECT_NEAR(angle, 0.0, 1e-12);
  }
}

TEST(RigidFloor, CarriesTheLoad) {
  FlexibleWheel wheel(wheel_file("amalia"));
  HubMotion hub;
  hub.position.z() = -RigidFloor::lowest_corner(wheel);
  wheel.place(hub);
  wheel.set_freedom({false, true, false});
  wheel.set_hub_load({{0.0, 0.0, -42.1}, Vector3d::Zero()});
  RigidFloor floor(wheel, {});
  Vector3d force = Vector3d::Zero();
  wheel.relax(1e-5, 150.0, 1e-8, 100000, [&](FlexibleWheel& w) { force = floor.press(w, 1e-5); });
  EXPECT_NEAR(force.z(), 42.1, 1e-3);
  EXPECT_NEAR(wheel.reaction().force.z(), 42.1, 1e-3);
}

}  // namespace
}  // namespace wheel_twin::wheel
