#include "terramechanics/wheel_on_soil.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/error.h"

namespace wheel_twin::terramechanics {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kLoad = 42.1;

Wheel flexible() {
  Wheel wheel;
  wheel.stiffness = 12000.0;
  wheel.grousers = 16;
  wheel.grouser_height = 0.007;
  return wheel;
}

Soil sand() {
  Soil soil;
  soil.c1 = 0.3;
  return soil;
}

/// Everything a state says, for comparisons of whole states.
std::vector<double> numbers(const ContactState& s) {
  return {s.sinkage,      s.hub_displacement, s.entry_angle,           s.exit_angle,       s.normal_load,
          s.drawbar_pull, s.side_force,       s.drive_torque,          s.torque_x,         s.torque_y,
          s.torque_z,     s.thrust,           s.compaction_resistance, s.bulldozing_force, s.grouser_thrust};
}

void expect_close(const ContactState& a, const ContactState& b, double relative) {
  const std::vector<double> x = numbers(a), y = numbers(b);
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(x[i], y[i], relative * (std::abs(x[i]) + 1e-3)) << "number " << i;
}

TEST(WheelOnSoil, VanishingDeflectionIsTheRigidWheel) {
  Wheel stiff = flexible(), rigid = flexible();
  rigid.stiffness.reset();
  for (const double slip : {-1.0, -0.3, 0.0, 0.4}) {
    for (const double steering : {0.0, 0.2}) {
      double previous = 1.0;
      for (const double stiffness : {1e8, 1e10, 1e12}) {
        stiff.stiffness = stiffness;
        const double a = WheelOnSoil(stiff, sand()).at_load(kLoad, {slip, steering}).drawbar_pull;
        const double b = WheelOnSoil(rigid, sand()).at_load(kLoad, {slip, steering}).drawbar_pull;
        EXPECT_LT(std::abs(a - b), previous);
        previous = std::max(std::abs(a - b), 1e-9);
      }
      // theta_d = sqrt(2 delta_d / R): 1e12 N/m leaves 1e-6 of the contact flat.
      stiff.stiffness = 1e15;
      expect_close(WheelOnSoil(stiff, sand()).at_load(kLoad, {slip, steering}),
                   WheelOnSoil(rigid, sand()).at_load(kLoad, {slip, steering}), 1e-5);
    }
  }
}

TEST(WheelOnSoil, ContinuousWhereThePeakLeavesTheFlatPatch) {
  // theta_m passes theta_d as c1 grows: the third stress enters ahead of the patch with nothing.
  const Wheel wheel = flexible();
  Soil soil = sand();
  soil.c2 = 0.0;
  const ContactState at = WheelOnSoil(wheel, soil).at_load(kLoad, {0.3, 0.0});
  const double c1 = at.deflection_angle / at.entry_angle;
  soil.c1 = c1 - 1e-9;
  const ContactState before = WheelOnSoil(wheel, soil).at_load(kLoad, {0.3, 0.0});
  soil.c1 = c1 + 1e-9;
  const ContactState after = WheelOnSoil(wheel, soil).at_load(kLoad, {0.3, 0.0});
  expect_close(before, after, 1e-7);
}

TEST(WheelOnSoil, ContinuousAtZeroSlip) {
  for (const double steering : {0.0, 0.1}) {
    const WheelOnSoil model(flexible(), sand());
    const ContactState zero = model.at_load(kLoad, {0.0, steering});
    expect_close(model.at_load(kLoad, {1e-9, steering}), zero, 1e-6);
    expect_close(model.at_load(kLoad, {-1e-9, steering}), zero, 1e-6);
  }
}

TEST(WheelOnSoil, ContinuousTowardsTheLockedWheel) {
  const WheelOnSoil model(flexible(), sand());
  expect_close(model.at_load(kLoad, {-1.0 + 1e-9, 0.0}), model.at_load(kLoad, {-1.0, 0.0}), 1e-6);
}

TEST(WheelOnSoil, PullGrowsWithSlipFromLockedToSpinning) {
  const WheelOnSoil model(flexible(), sand());
  double previous = -HUGE_VAL;
  for (int i = -20; i <= 20; ++i) {
    const ContactState state = model.at_load(kLoad, {0.05 * i, 0.0});
    EXPECT_GT(state.drawbar_pull, previous) << "slip " << 0.05 * i;
    previous = state.drawbar_pull;
  }
}

TEST(WheelOnSoil, SteeringToTheRightMirrorsSteeringToTheLeft) {
  const WheelOnSoil model(flexible(), sand());
  for (const double slip : {-1.0, -0.2, 0.0, 0.5}) {
    const ContactState left = model.at_load(kLoad, {slip, 0.3});
    const ContactState right = model.at_load(kLoad, {slip, -0.3});
    EXPECT_GT(left.side_force, 0.0);  // turned to the left, the soil pushes to +y
    EXPECT_DOUBLE_EQ(left.drawbar_pull, right.drawbar_pull);
    EXPECT_DOUBLE_EQ(left.side_force, -right.side_force);
    EXPECT_DOUBLE_EQ(left.drive_torque, right.drive_torque);
    EXPECT_DOUBLE_EQ(left.torque_x, -right.torque_x);
    EXPECT_DOUBLE_EQ(left.torque_z, -right.torque_z);
  }
  EXPECT_EQ(model.at_load(kLoad, {0.2, 0.0}).side_force, 0.0);
}

TEST(WheelOnSoil, ShearStaysWithinMohrCoulomb) {
  // Two independent displacements would exceed W tan(phi) at large steering angles and slips; one vector
  // cannot.
  Wheel wheel = flexible();
  wheel.grousers = 0;
  Soil soil = sand();
  soil.weight_density = 0.0;  // no bulldozing
  soil.K = 1e-3;
  const ContactState state = WheelOnSoil(wheel, soil).at_load(kLoad, {0.6, 0.4});
  const double along = state.thrust;
  const double across = -std::sin(0.4) * (state.drawbar_pull) + std::cos(0.4) * state.side_force;
  EXPECT_LT(std::hypot(along, across),
            1.25 * kLoad * std::tan(soil.phi));  // arcs are longer than their projection
}

TEST(WheelOnSoil, RigidFrictionlessWheelHasBekkersSinkageAndResistance) {
  // gamma = 0, theta_m = 0: the front arc alone. Bekker's closed form for a small sinkage,
  // W = b k z^(n + 1/2) sqrt(2 R) B(n + 1, 1/2) / 2 and R_c = b k z^(n+1) / (n + 1) (exact for the
  // resistance).
  Wheel wheel;
  wheel.radius = 1.0;
  Soil soil;
  soil.phi = soil.c = soil.gamma = soil.c1 = soil.c2 = 0.0;
  soil.k_phi = 1e9;
  for (const double n : {0.5, 1.0, 1.5}) {
    soil.n = n;
    const ContactState state = WheelOnSoil(wheel, soil).at_hub_displacement(1e-4, {0.2, 0.0});
    const double k = soil.k_c / wheel.width + soil.k_phi;
    EXPECT_NEAR(state.drawbar_pull, -wheel.width * k * std::pow(1e-4, n + 1.0) / (n + 1.0),
                1e-9 * state.normal_load);
    EXPECT_NEAR(state.compaction_resistance, -state.drawbar_pull, 1e-12 * state.normal_load);
    // Bekker's (3 - n) / 3 is the start of a series; its sum is half a beta function, 2/3 for n = 1 either
    // way.
    const double series = 0.5 * std::tgamma(n + 1.0) * std::tgamma(0.5) / std::tgamma(n + 1.5);
    const double bekker = wheel.width * k * std::pow(1e-4, n + 0.5) * std::sqrt(2.0) * series;
    EXPECT_NEAR(state.normal_load / bekker, 1.0, 2e-4) << n;  // the circle differs from its parabola by z / R
  }
}

TEST(WheelOnSoil, StaticSinkageOfAFlatWheelIsThePlate) {
  // A wheel so soft that nearly all of the load stands on the patch: W = b l_d k z^n.
  Wheel wheel;
  wheel.stiffness = 1000.0;
  Soil soil;
  soil.k_phi = 1e9;
  const ContactState state = WheelOnSoil(wheel, soil).at_rest_under_load(30.0);
  const double patch = 2.0 * std::sqrt(0.03 * (0.18 - 0.03));
  const double plate = 30.0 / (wheel.width * patch * (soil.k_c / wheel.width + soil.k_phi));
  EXPECT_NEAR(state.sinkage / plate, 1.0, 1e-3);
  EXPECT_EQ(state.drawbar_pull, 0.0);
  EXPECT_EQ(state.drive_torque, 0.0);
}

TEST(WheelOnSoil, SinkageFactorScalesTheSinkageOfTheLaw) {
  const WheelOnSoil model(flexible(), sand());
  const ContactState plain = model.at_load(kLoad, {0.3, 0.0});
  SoilChange loose;
  loose.sinkage_factor = 1.4;
  const ContactState deeper = model.at_load(kLoad, {0.3, 0.0}, loose);
  EXPECT_NEAR(deeper.sinkage, 1.4 * plain.sinkage, 1e-9 * plain.sinkage);
  EXPECT_NEAR(model.at_hub_displacement(deeper.hub_displacement, {0.3, 0.0}, loose).normal_load, kLoad,
              1e-7 * kLoad);
  // The same forces as of a soil so soft that the wheel sinks as deep, strength and stiffness alike.
  SoilChange soft;
  const auto sinkage = [&](double factor) {
    soft.stiffness_factor = factor;
    return model.at_load(kLoad, {0.3, 0.0}, soft).sinkage;
  };
  double low = 0.2, high = 1.0;
  for (int i = 0; i < 60; ++i)
    (sinkage(0.5 * (low + high)) > deeper.sinkage ? low : high) = 0.5 * (low + high);
  const ContactState softer = model.at_load(kLoad, {0.3, 0.0}, soft);
  EXPECT_NEAR(deeper.thrust, softer.thrust, 1e-6 * kLoad);
  EXPECT_NEAR(deeper.compaction_resistance, softer.compaction_resistance, 1e-6 * kLoad);
  EXPECT_GT(deeper.drive_torque, plain.drive_torque);
}

class DoubleAt final : public DepthFactor {
 public:
  double operator()(double) const override { return 2.0; }
};

TEST(WheelOnSoil, DepthFactorActsOnThePressure) {
  Soil soil = sand(), stiffer = sand();
  stiffer.k_c *= 2.0;
  stiffer.k_phi *= 2.0;
  const DoubleAt twice;
  SoilChange change;
  change.depth_factor = &twice;
  expect_close(WheelOnSoil(flexible(), soil).at_load(kLoad, {0.3, 0.1}, change),
               WheelOnSoil(flexible(), stiffer).at_load(kLoad, {0.3, 0.1}), 1e-9);
}

TEST(WheelOnSoil, GrousersInTheSoilAreTheShareOfTheTurnThatTouches) {
  const ContactState state = WheelOnSoil(flexible(), sand()).at_load(kLoad, {0.3, 0.0});
  const double arc = (state.entry_angle - state.deflection_angle) +
                     (-state.deflection_angle - state.exit_angle) + 2.0 * std::sin(state.deflection_angle);
  EXPECT_NEAR(state.grousers_in_soil, 16.0 * arc / (2.0 * M_PI), 1e-9);
  EXPECT_GT(state.grouser_thrust, 0.0);
  Wheel smooth = flexible();
  smooth.grousers = 0;
  EXPECT_EQ(WheelOnSoil(smooth, sand()).at_load(kLoad, {0.3, 0.0}).grouser_thrust, 0.0);
}

TEST(WheelOnSoil, FlexingResistanceComesOffThePullOfARollingWheel) {
  Wheel lossy = flexible();
  lossy.flexing_resistance = 1.5;
  const double plain = WheelOnSoil(flexible(), sand()).at_load(kLoad, {0.3, 0.0}).drawbar_pull;
  EXPECT_NEAR(WheelOnSoil(lossy, sand()).at_load(kLoad, {0.3, 0.0}).drawbar_pull, plain - 1.5, 1e-9);
  EXPECT_NEAR(WheelOnSoil(lossy, sand()).at_load(kLoad, {-1.0, 0.0}).drawbar_pull,
              WheelOnSoil(flexible(), sand()).at_load(kLoad, {-1.0, 0.0}).drawbar_pull, 1e-9);
}

TEST(WheelOnSoil, StiffnessIsTheSlopeOfTheLoad) {
  const WheelOnSoil model(flexible(), sand());
  const double h = 0.012, step = 1e-6;
  const ContactState at = model.at_hub_displacement(h, {0.3, 0.0});
  const double slope = (model.at_hub_displacement(h + step, {0.3, 0.0}).normal_load -
                        model.at_hub_displacement(h - step, {0.3, 0.0}).normal_load) /
                       (2.0 * step);
  EXPECT_NEAR(model.vertical_stiffness(at, {0.3, 0.0}), slope, 1e-3 * slope);
}

TEST(WheelOnSoil, NothingActsWithoutContact) {
  const WheelOnSoil model(flexible(), sand());
  const ContactState above = model.at_hub_displacement(-0.01, {0.3, 0.0});
  EXPECT_EQ(above.normal_load, 0.0);
  EXPECT_EQ(above.drawbar_pull, 0.0);
  EXPECT_EQ(model.at_load(0.0, {0.3, 0.0}).sinkage, 0.0);
}

TEST(WheelOnSoil, ImpossibleLoadsAreErrorsThatSaySo) {
  Wheel wheel = flexible();
  const WheelOnSoil model(wheel, sand());
  EXPECT_THAT(
      [&] {
        model.at_load(1200.0, {0.3, 0.0});
      },
      ThrowsMessage<Error>(HasSubstr("beyond its radius")))
      << "a load that deflects the wheel beyond its radius";
}

TEST(WheelOnSoil, LoadsBeyondTheSoilAreErrorsThatSaySo) {
  Wheel rigid = flexible();
  rigid.stiffness.reset();
  const WheelOnSoil model(rigid, sand());
  EXPECT_THAT(
      [&] {
        model.at_load(1e6, {0.3, 0.0});
      },
      ThrowsMessage<Error>(HasSubstr("no sinkage carries 1e+06 N, at most")));
  EXPECT_THAT([&] { model.at_rest_under_load(1e6); },
              ThrowsMessage<Error>(HasSubstr("at rest: no sinkage carries")));
  // A locked wheel digs: its shear pulls it down, and the force has a peak well before the hub reaches the
  // soil.
  EXPECT_THAT([&] { model.at_load(2000.0, {-1.0, 0.0}); }, ThrowsMessage<Error>(HasSubstr("at slip -1")));
  EXPECT_THAT(
      [&] {
        model.at_hub_displacement(0.1, {0.0, 0.0});
      },
      ThrowsMessage<Error>(HasSubstr("the radius is 0.09 m")));
}

TEST(WheelOnSoil, RefusesBadArguments) {
  const WheelOnSoil model(flexible(), sand());
  EXPECT_THAT([&] { model.at_load(-1.0, {0.0, 0.0}); }, ThrowsMessage<Error>(HasSubstr("load -1 N")));
  EXPECT_THAT([&] { model.at_load(NAN, {0.0, 0.0}); }, ThrowsMessage<Error>(HasSubstr("is not a load")));
  EXPECT_THAT([&] { model.at_load(1.0, {1.5, 0.0}); }, ThrowsMessage<Error>(HasSubstr("slip 1.5")));
  EXPECT_THAT([&] { model.at_load(1.0, {NAN, 0.0}); }, ThrowsMessage<Error>(HasSubstr("slip nan")));
  EXPECT_THAT(
      [&] {
        model.at_load(1.0, {0.0, 2.0});
      },
      ThrowsMessage<Error>(HasSubstr("steering angle 2 rad")));
  Soil bad = sand();
  bad.gamma = 2.0;
  EXPECT_THAT([&] { WheelOnSoil(flexible(), bad); }, ThrowsMessage<Error>(HasSubstr("gamma")));
}

}  // namespace
}  // namespace wheel_twin::terramechanics
