// A small wheel co-simulated with a small bed: energy book, action and reaction, the same bits whatever the
// threads and after a restart, and that the ports act.
#include "cosim/coupled_contact.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "base/error.h"
#include "cosim/dem_contact.h"
#include "cosim/grains.h"
#include "small_rig.h"

namespace wheel_twin::cosim {
namespace {

using Eigen::Vector3d;
using test::SmallRun;

struct Outcome {
  rig::RunSummary summary;
  std::vector<rig::HubLoad> answers;
  std::vector<double> wheel;
  dem::State soil;
};

Outcome outcome_of(SmallRun& run) {
  rig::FreeRun free_run(run.settings, run.contact, run.ports);
  Outcome outcome;
  rig::run_to_end(free_run, outcome.summary);
  const CouplingState state = run.contact.state();
  outcome.answers = state.answers;
  outcome.wheel = state.wheel;
  outcome.soil = run.dem.state();
  return outcome;
}

void expect_same_bits(const Outcome& a, const Outcome& b) {
  ASSERT_EQ(a.answers.size(), b.answers.size());
  for (std::size_t i = 0; i < a.answers.size(); ++i) {
    ASSERT_EQ(a.answers[i].force_hub_rig, b.answers[i].force_hub_rig) << "call " << i;
    ASSERT_EQ(a.answers[i].torque_hub_rig, b.answers[i].torque_hub_rig) << "call " << i;
  }
  EXPECT_EQ(a.wheel, b.wheel);
  EXPECT_EQ(a.soil.position, b.soil.position);
  EXPECT_EQ(a.soil.velocity, b.soil.velocity);
  EXPECT_EQ(a.soil.orientation, b.soil.orientation);
}

/// The run of reference, simulated once.
const Outcome& reference() {
  static const Outcome outcome = [] {
    SmallRun run;
    return outcome_of(run);
  }();
  return outcome;
}

TEST(CoupledContact, CarriesTheLoadAndPulls) {
  const rig::RunSummary& mean = reference().summary;
  // Grains carry the dead weight, but for what the slide's 0.41 kg gain or lose of some 0.1 m/s over the
  // window of 0.15 s.
  EXPECT_NEAR(mean.normal_load, 4.0, 0.6);
  EXPECT_GT(mean.drive_torque, 0.0);
  // Friction of the rim (0.5) bounds the pull.
  EXPECT_LT(std::abs(mean.drawbar_pull), 0.5 * 4.0);
  EXPECT_LT(mean.drive_torque, 0.5 * 4.0 * 0.045);
}

TEST(CoupledContact, TwoThreadsGiveTheSameBits) {
  SmallRun run(2);
  expect_same_bits(reference(), outcome_of(run));
}

TEST(CoupledContact, ARestartGivesTheSameBits) {
  CouplingState halfway;
  dem::State soil;
  {
    SmallRun first;
    rig::FreeRun run(first.settings, first.contact, first.ports);
    for (int i = 0; i < 300; ++i) run.advance();
    halfway = first.contact.state();
    soil = first.dem.state();
  }
  SmallRun second;
  second.dem.restore(soil);
  second.contact.resume(halfway);
  EXPECT_TRUE(second.contact.replaying());
  expect_same_bits(reference(), outcome_of(second));
}

SmallRun windowed() {
  return SmallRun(1, false, test::small_wheel(), {}, BedWindow{0.05, 0.05});
}

TEST(CoupledContact, AWindowHoldsTheRestAndCarriesTheSame) {
  SmallRun run = windowed();
  const dem::State before = run.dem.state();
  const Outcome outcome = outcome_of(run);
  std::size_t still = 0;
  for (std::size_t k = 0; k < before.position.size(); ++k) {
    if (before.position[k] == outcome.soil.position[k]) ++still;
  }
  EXPECT_GT(still, before.position.size() / 10);
  EXPECT_LT(still, before.position.size() / 2);
  EXPECT_NEAR(outcome.summary.normal_load, 4.0, 0.6);  // as without, above
  EXPECT_GT(outcome.summary.drive_torque, 0.0);
}

TEST(CoupledContact, ARestartInAWindowGivesTheSameBits) {
  SmallRun whole = windowed();
  const Outcome reference = outcome_of(whole);
  CouplingState halfway;
  dem::State soil;
  {
    SmallRun first = windowed();
    rig::FreeRun run(first.settings, first.contact, first.ports);
    for (int i = 0; i < 300; ++i) run.advance();
    halfway = first.contact.state();
    soil = first.dem.state();
  }
  SmallRun second = windowed();
  second.dem.restore(soil);
  second.contact.resume(halfway);
  expect_same_bits(reference, outcome_of(second));
  EXPECT_NE(second.dem.fingerprint(), SmallRun().dem.fingerprint());
}

// The height at which a run starts comes from the bed as it was made, not from the rut of the restored one.
TEST(DemContact, ACheckpointFileGivesTheSameBits) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("dem_contact_{}", getpid());
  std::filesystem::create_directories(folder);
  setenv("WHEEL_TWIN_CACHE", folder.c_str(), 1);
  DemSettings settings;
  settings.bed.length = 0.15;
  settings.bed.width = 0.06;
  settings.bed.depth = 0.03;
  settings.bed.fill_friction = 0.5;
  settings.start_x = 0.05;
  const std::string path = folder / "checkpoint.h5";
  SmallRun small;
  std::vector<dem::State> ends;
  double clearance = 0.0;
  for (const bool resumed : {false, true}) {
    DemContact contact(test::small_wheel(), test::soil(), settings, {}, 1);
    if (resumed) contact.resume(path);
    if (!resumed) clearance = contact.clearance();
    EXPECT_EQ(contact.clearance(), clearance);
    rig::RunSettings course = small.settings;
    course.profile.clearance = contact.clearance();
    rig::FreeRun run(course, contact, {});
    for (int i = 0; i < 200; ++i) {
      run.advance();
      if (!resumed && i == 150) contact.write_checkpoint(path);
    }
    ends.push_back(contact.soil().state());
  }
  EXPECT_LT(ends[0].position.size(), 1000U);
  EXPECT_EQ(ends[0].position, ends[1].position);
  EXPECT_EQ(ends[0].velocity, ends[1].velocity);
  std::filesystem::remove_all(folder);
}

TEST(CoupledContact, ACheckpointOfAnotherRunIsRefused) {
  CouplingState halfway;
  dem::State soil;
  {
    SmallRun first;
    rig::FreeRun run(first.settings, first.contact, first.ports);
    for (int i = 0; i < 30; ++i) run.advance();
    halfway = first.contact.state();
    soil = first.dem.state();
  }
  SmallRun other;
  other.settings.conditions.load = 5.0;
  other.settings.profile.lowering_speed = 0.09;
  other.dem.restore(soil);
  other.contact.resume(halfway);
  EXPECT_THROW(outcome_of(other), Error);
}

// Every joule that the hub puts in is found in the rim, or goes through the walls into the soil and is found
// there: kinetic, elastic, potential, or lost in contacts.
TEST(CoupledContact, TheEnergyBookCloses) {
  SmallRun run(1, true);
  const dem::EnergyBook before = run.dem.system().energy();
  rig::FreeRun free_run(run.settings, run.contact, run.ports);
  rig::RunSummary summary;
  rig::run_to_end(free_run, summary);
  const dem::EnergyBook after = run.dem.system().energy();
  const CouplingEnergy coupling = run.contact.energy();
  const auto content = [](const dem::EnergyBook& e) {
    return e.kinetic + e.potential + e.elastic + e.damped + e.friction;
  };
  const double soil_gain = content(after) - content(before);
  const double rim_gain = coupling.wheel.kinetic + coupling.wheel.elastic + coupling.wheel.dissipated;
  const double scale = coupling.hub_work;
  ASSERT_GT(scale, 0.01);
  EXPECT_NEAR(coupling.hub_work + coupling.soil_work, rim_gain, 0.005 * scale);
  EXPECT_NEAR(after.wall_work - before.wall_work, -coupling.soil_work, 0.005 * scale);
  EXPECT_NEAR(soil_gain, after.wall_work - before.wall_work, 0.005 * scale);
  EXPECT_NEAR(coupling.hub_work, rim_gain + soil_gain, 0.005 * scale);
}

// What the segments receive is what the grains lose: the walls' forces change the bed's momentum, beside
// gravity and the floor.
TEST(CoupledContact, ActionIsReaction) {
  SmallRun run;
  rig::FreeRun free_run(run.settings, run.contact, run.ports);
  for (int i = 0; i < 200; ++i) free_run.advance();
  const dem::System& system = run.dem.system();
  Vector3d on_grains = Vector3d::Zero();
  for (const dem::Wrench& load : system.loads()) on_grains += load.force;
  Vector3d on_rim = Vector3d::Zero();
  for (const wheel::Wrench& load : run.contact.soil_loads()) on_rim += load.force;
  const Vector3d on_floor = system.wall_wrench(0).force;
  ASSERT_GT(on_rim.norm(), 0.1);
  // Forces between grains cancel; sums on walls are rounded to 1024 quanta of 4e-12 N.
  EXPECT_NEAR((on_grains + on_rim + on_floor).norm(), 0.0, 1e-5);
}

TEST(CoupledContact, ARigidWheelGivesTheHubWhatTheSoilGivesTheRim) {
  wheel::WheelModel model = test::small_wheel(wheel::Suspension::rigid);
  SmallRun run(1, false, model);
  rig::FreeRun free_run(run.settings, run.contact, run.ports);
  // Hub and rim are one: over the run, the impulses differ by the rim's momentum alone.
  Vector3d hub = Vector3d::Zero();
  Vector3d soil = Vector3d::Zero();
  for (int i = 0; i < 300; ++i) {
    const rig::RigStep& step = free_run.advance();
    hub += step.load.force_hub_rig;
    for (const wheel::Wrench& load : run.contact.soil_loads()) soil += load.force;
  }
  EXPECT_NEAR((hub - soil).norm() / 300.0, 0.0, 0.05 * soil.norm() / 300.0);
}

/// Lifts the hub by a millimetre at one side of the wheel.
class Eccentric final : public rig::WheelPort {
 public:
  double hub_rise(const rig::RigState& state) const override { return 1e-3 * std::cos(state.wheel_angle); }
};

class Slope final : public rig::SoilPort {
 public:
  double surface_slope(const rig::RigState&) const override { return 0.1; }
};

class Twice final : public rig::SoilPort {
 public:
  double stiffness_factor(const rig::RigState&) const override { return 2.0; }
};

class SlipDependent final : public rig::SoilPort {
 public:
  double sinkage_factor(const rig::RigState& state) const override { return 1.0 + state.slip; }
};

TEST(CoupledContact, AnEccentricWheelSitsLower) {
  const Eccentric eccentric;
  rig::Ports ports;
  ports.wheel.push_back(&eccentric);
  SmallRun plain;
  SmallRun run(1, false, test::small_wheel(), ports);
  rig::HubMotion motion;
  motion.position.z() = 0.05;
  plain.contact.advance(motion);
  run.contact.advance(motion);
  EXPECT_NEAR(plain.contact.wheel().hub().position.z() - run.contact.wheel().hub().position.z(), 1e-3, 1e-12);
}

TEST(DemContact, ARunStartsHigherByWhatAnEccentricWheelSitsLower) {
  const Eccentric eccentric;
  rig::Ports ports;
  ports.wheel.push_back(&eccentric);
  SmallRun run(1, false, test::small_wheel(), ports);
  const wheel::FlexibleWheel& wheel = run.contact.wheel();
  rig::HubMotion motion;
  motion.position.z() = start_clearance(run.dem, wheel, ports);
  EXPECT_NEAR(motion.position.z() - start_clearance(run.dem, wheel, {}), 1e-3, 1e-12);
  EXPECT_EQ(run.contact.advance(motion).force_hub_rig.z(),
            SmallRun().contact.advance(motion).force_hub_rig.z())
      << "a grain touches the wheel at the start";
}

TEST(CoupledContact, ASlopeTurnsTheBedAgainstTheRig) {
  const Slope slope;
  rig::Ports ports;
  ports.soil.push_back(&slope);
  SmallRun run(1, false, test::small_wheel(), ports);
  // A point of the surface ahead lies higher in the rig; gravity in the bed's axes points back.
  const Vector3d ahead = run.dem.to_rig({0.05 + 0.02, 0.0, 0.0});
  EXPECT_NEAR(ahead.z(), 0.02 * std::sin(0.1), 1e-12);
  EXPECT_NEAR((run.dem.to_bed(ahead) - Vector3d(0.07, 0.0, 0.0)).norm(), 0.0, 1e-12);
  const Vector3d gravity = run.dem.system().settings().gravity;
  EXPECT_NEAR(gravity.x(), -9.81 * std::sin(0.1), 1e-9);
  EXPECT_NEAR(gravity.z(), -9.81 * std::cos(0.1), 1e-9);
}

// Density and moduli times f leave the settled bed as it is and make every force f times as large.
TEST(CoupledContact, AStifferSoilCarriesMoreAtTheSameSinkage) {
  const Twice twice;
  rig::Ports ports;
  ports.soil.push_back(&twice);
  double impulse[2] = {0.0, 0.0};
  for (int k = 0; k < 2; ++k) {
    SmallRun run(1, false, test::small_wheel(wheel::Suspension::rigid), k == 0 ? rig::Ports{} : ports);
    const double top = run.settings.profile.clearance;
    rig::HubMotion motion;
    motion.velocity.z() = -0.05;
    for (int i = 0; i <= 60; ++i) {  // 3 mm into the soil
      motion.time = 0.001 * i;
      motion.position.z() = top + motion.velocity.z() * motion.time;
      impulse[k] += 0.001 * run.contact.advance(motion).force_hub_rig.z();
    }
  }
  // The steel's own compliance, a thousandth of the grains', is not doubled; grains that slip early or late
  // because of it make the rest.
  EXPECT_NEAR(impulse[1] / impulse[0], 2.0, 0.1);
}

// The step goes with the mobility's square root, and, as Hertz' stiffness under a force does, with the third
// root of the modulus.
TEST(CoupledContact, ALightRimOnStiffGrainsShortensTheStep) {
  const Twice twice;
  const auto step_of = [&](double mobility, const std::vector<const rig::SoilPort*>& acting) {
    DemSoilSettings settings = SmallRun::soil_settings(1, false);
    settings.rim_mobility = mobility;
    return DemSoil(test::soil(), test::small_bed(), test::shapes_of(test::small_wheel()), settings, acting)
        .time_step();
  };
  const double calm = step_of(0.0, {}), shaken = step_of(1e6, {});
  EXPECT_EQ(step_of(1e3, {}), calm);
  EXPECT_LT(shaken, 0.5 * calm);
  EXPECT_NEAR(step_of(4e6, {}) / shaken, 0.5, 0.01);
  EXPECT_NEAR(step_of(1e6, {&twice}) / shaken, std::pow(2.0, -1.0 / 3.0), 0.01);
}

TEST(CoupledContact, WhatGrainsDoByThemselvesIsRefused) {
  const SlipDependent loosening;
  rig::Ports ports;
  ports.soil.push_back(&loosening);
  EXPECT_THROW(SmallRun(1, false, test::small_wheel(), ports), Error);
}

TEST(Grains, APeriodicBedIsDrawnAboutTheWheel) {
  const Slope slope;
  rig::Ports tilted;
  tilted.soil.push_back(&slope);
  for (const rig::Ports& ports : {rig::Ports{}, tilted}) {
    const SmallRun run(1, false, test::small_wheel(), ports);
    const double length = test::small_bed().settings.length;
    const double hub = run.dem.to_bed({1.0, 0.0, 0.0}).x();
    const std::vector<dem::SphereState> spheres = run.dem.system().spheres();
    const std::vector<dem::SphereState> drawn = spheres_about(run.dem, 1.0);
    ASSERT_EQ(drawn.size(), spheres.size());
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      const Vector3d place = run.dem.to_bed(drawn[i].center);
      const Vector3d moved = place - spheres[i].center;
      EXPECT_LE(std::abs(place.x() - hub), 0.5 * length + 1e-12);
      EXPECT_NEAR(std::remainder(moved.x(), length), 0.0, 1e-12);
      EXPECT_NEAR(moved.tail<2>().norm(), 0.0, 1e-12);
    }
  }
}

TEST(CoupledContact, AnUnevenStepIsRefused) {
  SmallRun run;
  rig::HubMotion motion;
  motion.position.z() = 0.05;
  run.contact.advance(motion);
  motion.time = 1.5 * run.dem.time_step();
  EXPECT_THROW(run.contact.advance(motion), Error);
}

}  // namespace
}  // namespace wheel_twin::cosim
