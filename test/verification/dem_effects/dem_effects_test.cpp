// Every physical effect of the catalogue acts on a wheel that is co-simulated with a discrete-element bed,
// and by as much as it says. Closed forms: the slide's momentum, the weight of the grains, the geometry of
// hub, wheel and bed. Effects that grains or the wheel have by themselves are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "../../unit/cosim/small_rig.h"
#include "base/error.h"
#include "cosim/soil_change.h"
#include "effects/catalogue.h"

namespace wheel_twin::cosim {
namespace {

using Eigen::Vector3d;
using test::SmallRun;

/// An effect of the catalogue, attached.
struct Acting {
  std::unique_ptr<effects::Effect> effect;
  rig::Ports ports;

  Acting(const std::string& name, const std::vector<double>& values)
      : effect(effects::make_effect(effects::find_effect(name), values)) {
    effect->attach(ports);
  }
};

struct SteppedRun {
  SmallRun run;
  std::vector<rig::RigStep> steps;  ///< of the rig, 1 ms each

  explicit SteppedRun(const rig::Ports& ports, int count = 350, double steering = 0.0)
      : run(1, false, test::small_wheel(), ports) {
    run.settings.rig.carriage.belt_stiffness.reset();
    run.settings.conditions.steering_angle = steering;
    rig::FreeRun free_run(run.settings, run.contact, run.ports);
    steps.push_back(free_run.step());
    for (int i = 0; i < count && !free_run.done(); ++i) steps.push_back(free_run.advance());
  }
};

const SteppedRun& plain() {
  static const SteppedRun run{rig::Ports{}};
  return run;
}

/// Impulse on the slide (N s) that its momentum, its damping and the soil leave over, steps on the hoist left
/// out, and the time over which it acted, s: minus the weight and what else pulls.
struct Balance {
  double impulse = 0.0;
  double time = 0.0;
  double down = 0.0;   ///< time while the slide sank, s
  double stuck = 0.0;  ///< time in which it changed direction or stood, s
};
Balance slide_balance(const SteppedRun& stepped, double weight) {
  const rig::RigSettings& rig = stepped.run.settings.rig;
  const double mass = weight / rig.gravity, dt = stepped.run.settings.step;
  Balance balance;
  for (std::size_t i = 1; i < stepped.steps.size(); ++i) {
    const rig::RigStep &before = stepped.steps[i - 1], &now = stepped.steps[i];
    if (now.hoist_taut || before.hoist_taut) continue;
    const double v0 = before.state.slide_velocity, v1 = now.state.slide_velocity;
    balance.impulse +=
        dt * (before.load.force_hub_rig.z() - rig.slide.viscous_damping * v1) - mass * (v1 - v0);
    balance.time += dt;
    if (v1 == 0.0) balance.stuck += dt;
    if (v1 < 0.0) balance.down += dt;
  }
  return balance;
}

TEST(DemEffects, DeadWeightErrorLoadsTheSoil) {
  const Acting acting("dead_weight_error", {1.5});
  const SteppedRun stepped(acting.ports);
  const Balance balance = slide_balance(stepped, 5.5);
  ASSERT_GT(balance.time, 0.2);
  // The soil carries 4 N as set and the 1.5 N.
  EXPECT_NEAR(balance.impulse / balance.time, 5.5, 1e-9);
  const Balance without = slide_balance(plain(), 4.0);
  EXPECT_NEAR(without.impulse / without.time, 4.0, 1e-9);
}

TEST(DemEffects, SlideFrictionHoldsTheSinkingSlide) {
  const double friction = 0.8;
  const Acting acting("slide_friction", {friction});
  const SteppedRun stepped(acting.ports);
  const Balance balance = slide_balance(stepped, 4.0);
  const double up = balance.time - balance.down - balance.stuck;
  // What the guide takes: f while sinking, -f while rising; a slide that stands takes anything in between.
  const double held = 4.0 * balance.time - balance.impulse;
  EXPECT_GT(balance.down, 0.02);
  EXPECT_NEAR(held, friction * (balance.down - up), friction * balance.stuck + 1e-9);
  EXPECT_GT(friction * balance.down, held - friction * balance.stuck - 1e-9);
}

TEST(DemEffects, ComplianceAndDragChangeTheReadingsAlone) {
  const Acting compliance("rig_compliance", {1e-4});
  const Acting drag("motor_drag", {0.3});
  rig::Ports both = compliance.ports;
  both.rig.insert(both.rig.end(), drag.ports.rig.begin(), drag.ports.rig.end());
  both.sensor.insert(both.sensor.end(), drag.ports.sensor.begin(), drag.ports.sensor.end());
  const SteppedRun stepped(both);
  ASSERT_EQ(stepped.steps.size(), plain().steps.size());
  int turning = 0;
  for (std::size_t i = 0; i < stepped.steps.size(); ++i) {
    const rig::RigStep &with = stepped.steps[i], &without = plain().steps[i];
    ASSERT_EQ(with.load.force_hub_rig, without.load.force_hub_rig) << "step " << i;
    const double given_way = with.readings.displacement - without.readings.displacement;
    EXPECT_NEAR(given_way, 1e-4 * with.load.force_hub_rig.z(), 1e-12) << "step " << i;
    if (with.state.wheel_rate < 0.1) continue;
    ++turning;
    EXPECT_NEAR(with.readings.joints.wheel_effort - without.readings.joints.wheel_effort, 0.3, 1e-12)
        << "step " << i;
  }
  EXPECT_GT(turning, 100);
}

TEST(DemEffects, CarriageSpeedErrorMovesTheWheelFurtherThanLogged) {
  const Acting acting("carriage_speed_error", {0.25});
  const SteppedRun stepped(acting.ports);
  const rig::RigStep& last = stepped.steps.back();
  ASSERT_GT(last.readings.joints.carriage_position, 0.003);
  EXPECT_NEAR(last.motion.position.x(), 1.25 * last.readings.joints.carriage_position, 1e-12);
  // The wheel that the soil meets is there.
  EXPECT_NEAR(stepped.run.contact.wheel().hub().position.x(), last.motion.position.x(), 1e-12);
}

TEST(DemEffects, SteeringMisalignmentTurnsTheWheelAndTheSoilPushesIt) {
  double side[2];
  for (int k = 0; k < 2; ++k) {
    const double angle = k == 0 ? 0.3 : -0.3;
    const Acting acting("steering_misalignment", {angle});
    const SteppedRun stepped(acting.ports);
    // Heading of the lowest segment's axle: turned to the left by the angle.
    const Vector3d axle = stepped.run.contact.segments()[0].orientation * Vector3d::UnitY();
    EXPECT_NEAR((axle - Vector3d(-std::sin(angle), std::cos(angle), 0.0)).norm(), 0.0, 1e-12);
    side[k] = 0.0;
    for (std::size_t i = 200; i < stepped.steps.size(); ++i)
      side[k] += stepped.steps[i].load.force_hub_rig.y();
  }
  EXPECT_GT(side[0], 0.0);  // to +y (architecture)
  EXPECT_LT(side[1], 0.0);
}

TEST(DemEffects, EccentricityAndSoftSpokeMoveTheWheelUnderTheHub) {
  const double amplitude = 1.5e-3, phase = 0.4, drop = 1e-3, half_angle = 0.2, at = -0.3;
  const Acting eccentric("wheel_eccentricity", {amplitude, phase});
  const Acting soft("soft_spoke", {drop, half_angle, at});
  rig::Ports both = eccentric.ports;
  both.wheel.insert(both.wheel.end(), soft.ports.wheel.begin(), soft.ports.wheel.end());
  SmallRun run(1, false, test::small_wheel(), both);
  rig::FreeRun free_run(run.settings, run.contact, run.ports);
  double largest = 0.0;
  while (!free_run.done()) {
    const rig::RigStep& step = free_run.advance();
    const double angle = step.motion.wheel_angle, u = (angle + at) / half_angle;
    const double rise = amplitude * std::cos(angle + phase) - drop * std::exp(-0.5 * u * u);
    const double wheel = run.contact.wheel().hub().position.z();
    ASSERT_NEAR(step.motion.position.z() + run.contact.radius() - wheel, rise, 1e-12);
    largest = std::max(largest, angle);
  }
  EXPECT_GT(largest, 0.3) << "the wheel must turn over the soft spoke";
}

TEST(DemEffects, BedTiltTurnsGravityInTheBed) {
  const double angle = 0.12;
  const Acting acting("bed_tilt", {angle});
  SmallRun level, tilted(1, false, test::small_wheel(), acting.ports);
  // The floor holds the grains' weight, along the slope as across it; the wheel is far above.
  const auto on_floor_of = [](SmallRun& run) {
    rig::HubMotion motion;
    motion.position.z() = 0.1;
    for (int i = 0; i < 20; ++i) {
      motion.time = 0.001 * i;
      run.contact.advance(motion);
    }
    return run.dem.system().wall_wrench(0).force;
  };
  const double weight = -on_floor_of(level).z();
  const Vector3d on_floor = on_floor_of(tilted);
  EXPECT_NEAR(on_floor.x(), -weight * std::sin(angle), 0.03 * weight * std::sin(angle));
  EXPECT_NEAR(on_floor.z(), -weight * std::cos(angle), 0.01 * weight);
  // Uphill along the rig's x.
  EXPECT_NEAR(tilted.dem.to_rig({0.05 + 0.02, 0.0, 0.0}).z(), 0.02 * std::sin(angle), 1e-12);
}

/// Pressure-sinkage factor of an effect of the soil in closed form, at x (m from the run's start) and depth
/// (m).
struct StiffnessCase {
  std::string name;
  std::vector<double> values;
  double (*factor)(double x, double depth);
};
void PrintTo(const StiffnessCase& one, std::ostream* out) {
  *out << one.name;
}

class SoilStiffness : public ::testing::TestWithParam<StiffnessCase> {};
INSTANTIATE_TEST_SUITE_P(
    Catalogue, SoilStiffness,
    ::testing::Values(
        StiffnessCase{"multi_pass", {0.7}, [](double, double) { return 1.7; }},
        StiffnessCase{"density_gradient", {5.0}, [](double x, double) { return 1.0 + 5.0 * x; }},
        StiffnessCase{"hard_layer", {0.012}, [](double, double z) { return 1.0 + std::pow(z / 0.012, 3.0); }},
        StiffnessCase{"buried_rock",
                      {0.03, 0.01, 12.0, 1.0, 0.0},
                      [](double x, double) {
                        const double u = (x - 0.03) / 0.01;
                        return 1.0 + 12.0 * std::exp(-0.5 * u * u);
                      }}),
    [](const auto& one) { return one.param.name; });

// Grains with f times density and moduli carry f times the pressure at the same sinkage: every grain has the
// factor of its place, to half a level.
TEST_P(SoilStiffness, EveryGrainHasTheFactorOfItsPlace) {
  const Acting acting(GetParam().name, GetParam().values);
  const dem::Bed& bed = test::small_bed();
  const double start_x = SmallRun::soil_settings(1, false).start_x;
  const ChangedBed changed = change_bed(test::soil(), bed, start_x, acting.ports.soil);
  double low = 1e30, high = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < bed.state.position.size(); ++i) {
    const Vector3d& p = bed.state.position[i];
    const double factor = GetParam().factor(p.x() - start_x, std::max(0.0, -p.z()));
    const dem::Material& material = changed.materials[changed.state.material[i]];
    const double density = material.density / test::soil().grain.density;
    EXPECT_NEAR(material.shear_modulus / test::soil().grain.shear_modulus, density, 1e-9 * density);
    low = std::min(low, factor);
    high = std::max(high, factor);
    worst = std::max(worst, std::abs(std::log(density / factor)));
  }
  EXPECT_LE(worst, 0.5 * std::log(high / low) / 17.0 + 1e-9);
}

/// Impulse (N s) of the soil on a rigid wheel that is pressed 3 mm into it at `x`.
double pressed(const rig::Ports& ports, double x) {
  SmallRun run(1, false, test::small_wheel(wheel::Suspension::rigid), ports);
  rig::HubMotion motion;
  motion.velocity.z() = -0.05;
  const double top = run.dem.first_touch(x, 0.041, 0.03) - run.contact.radius();
  double impulse = 0.0;
  for (int i = 0; i <= 60; ++i) {
    motion.time = 0.001 * i;
    motion.position = {x, 0.0, top + motion.velocity.z() * motion.time};
    impulse += 0.001 * run.contact.advance(motion).force_hub_rig.z();
  }
  return impulse;
}

// The wheel meets it: pressed into the soil it is carried by the factor of the place more. Grains that slip
// early or late make single places differ, so several are taken together.
TEST_P(SoilStiffness, TheWheelIsCarriedByTheFactor) {
  const Acting acting(GetParam().name, GetParam().values);
  const std::string& name = GetParam().name;
  if (name == "buried_rock" || name == "hard_layer") {
    const double x = 0.03;  // the rock's place
    const double ratio = pressed(acting.ports, x) / pressed({}, x);
    // More than bare soil; less than the rock that is as wide as the contact, than the stiffest of the
    // layers.
    EXPECT_GT(ratio, 1.1);
    EXPECT_LT(ratio, GetParam().factor(x, 0.03));
    return;
  }
  double expected = 0.0, found = 0.0;
  for (const double x : {-0.03, -0.01, 0.01, 0.03, 0.05, 0.07}) {
    expected += GetParam().factor(x, 0.0) * pressed({}, x);
    found += pressed(acting.ports, x);
  }
  EXPECT_NEAR(found / expected, 1.0, 0.06);
}

// Backwards from the attraction to the strength: overlap of a contact under it and a share of the bed's
// weight (Hertz), force of the attraction on it, Rumpf's tensile strength, times the grains' friction.
TEST(DemEffects, CohesionIsRumpfsStrengthOfTheAttraction) {
  const Acting acting("soil_cohesion", {800.0});
  const dem::GranularSoil& soil = test::soil();
  const dem::Bed& bed = test::small_bed();
  const ChangedBed changed =
      change_bed(soil, bed, SmallRun::soil_settings(1, false).start_x, acting.ports.soil);
  EXPECT_TRUE(changed.changed);
  EXPECT_EQ(changed.materials.pair(0, 1).cohesion_energy_density, 0.0) << "the wheel stays clean";
  const double k = changed.materials.pair(0, 0).cohesion_energy_density;
  const double R = 0.5 * soil.clumps.smallest_radius() / soil.clumps.smallest_size;
  const double nu = soil.grain.poisson_ratio, E = soil.grain.youngs_modulus() / (2.0 * (1.0 - nu * nu));
  const double d = std::cbrt(6.0 * soil.clumps.mean_volume() / M_PI), area = M_PI * d * d;
  const double contacts = soil.packing_density * bed.report.coordination.per_clump;
  const double carried = soil.grain.density * soil.packing_density * 9.81 * 0.03 * area / contacts;
  double low = 0.0, high = R;
  for (int i = 0; i < 200; ++i) {
    const double delta = 0.5 * (low + high);
    const double resists = 4.0 / 3.0 * E * std::sqrt(R) * std::pow(delta, 1.5);
    (resists > k * 2.0 * M_PI * R * delta + carried ? high : low) = delta;
  }
  const double force = k * 2.0 * M_PI * R * low;
  EXPECT_NEAR(contacts * force / area * soil.grain_grain.friction, 800.0, 1.0);
}

// A periodic bed comes round: what varies along it is laid out once, and a run that goes further is stopped.
TEST(DemEffects, ARunBeyondTheBedIsStopped) {
  const Acting acting("density_gradient", {2.0});
  SmallRun run(1, false, test::small_wheel(wheel::Suspension::rigid), acting.ports);
  const double last = test::small_bed().settings.length - 0.05;
  const auto at = [&](double x, double time) {
    rig::HubMotion motion;
    motion.time = time;
    motion.position = {x, 0.0, 0.1};
    run.contact.advance(motion);
  };
  at(0.0, 0.0);
  EXPECT_NO_THROW(at(last - 0.001, 0.001));
  try {
    at(last + 0.002, 0.002);
    ADD_FAILURE() << "the run went on";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("comes round 0.100 m from the start"));
  }
}

TEST(DemEffects, WhatIsEmergentIsRefused) {
  for (const auto& [name, values] : std::vector<std::pair<std::string, std::vector<double>>>{
           {"slip_sinkage", {0.7, 0.06}}, {"wheel_flexing_resistance", {1.0}}}) {
    const Acting acting(name, values);
    try {
      SmallRun run(1, false, test::small_wheel(), acting.ports);
      ADD_FAILURE() << name << " was taken";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("leave")) << name;
    }
  }
}

}  // namespace
}  // namespace wheel_twin::cosim
