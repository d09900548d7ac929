#include "rig/slide.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "test_contact.h"

namespace wheel_twin::rig {
namespace {

constexpr double g = 9.80665;

TEST(Slide, FallsFreelyWithoutSoil) {
  SlideForces forces;
  forces.weight = 42.1;
  const double mass = 42.1 / g;
  double velocity = 0.0;
  for (int i = 0; i < 500; ++i)
    velocity = slide_velocity(forces, mass, velocity, 0.001, std::nullopt).velocity;
  EXPECT_NEAR(velocity, -g * 0.5, 1e-12);  // momentum gained = weight times time, to round-off
}

/// Mechanical energy of an oscillation on a spring after 0.2 s, over that at the start.
double energy_left(double dt) {
  const double stiffness = 4000.0, mass = 4.0, weight = mass * g;
  double height = -0.5 * weight / stiffness, velocity = 0.0;  // half of the static sinkage
  const auto energy = [&] {
    const double from_equilibrium = height + weight / stiffness;
    return 0.5 * mass * velocity * velocity + 0.5 * stiffness * from_equilibrium * from_equilibrium;
  };
  const double start = energy();
  SlideForces forces;
  forces.weight = weight;
  forces.stiffness = stiffness;
  const int steps = static_cast<int>(std::lround(0.2 / dt));
  for (int i = 0; i < steps; ++i) {
    forces.soil = -stiffness * height;
    velocity = slide_velocity(forces, mass, velocity, dt, std::nullopt).velocity;
    height += velocity * dt;
  }
  return energy() / start;
}

TEST(Slide, LosesEnergyToTheStepAtFirstOrder) {
  // Linearly implicit Euler damps an oscillator of w = sqrt(k/m) by exp(-w^2 dt t) in energy, to first order
  // in dt.
  const double w2 = 4000.0 / 4.0;
  const double loss = 1.0 - energy_left(1e-4);
  EXPECT_NEAR(loss, 1.0 - std::exp(-w2 * 1e-4 * 0.2), 0.02 * loss);
  EXPECT_NEAR((1.0 - energy_left(5e-5)) / loss, 0.5, 0.01);
  EXPECT_LE(energy_left(1e-3), 1.0);
}

TEST(Slide, StaysStableFarBeyondTheExplicitLimit) {
  SlideForces forces;
  forces.weight = 42.1;
  forces.stiffness = 1e8;  // explicit limit: 2 sqrt(m/k) = 0.4 ms
  double height = -1e-4, velocity = 0.0;
  for (int i = 0; i < 1000; ++i) {
    forces.soil = -forces.stiffness * height;
    velocity = slide_velocity(forces, 42.1 / g, velocity, 0.01, std::nullopt).velocity;
    height += velocity * 0.01;
  }
  EXPECT_NEAR(-forces.stiffness * height, 42.1, 1e-9);
}

TEST(Slide, ViscousDampingSetsTheTerminalVelocity) {
  SlideForces forces;
  forces.weight = 42.1;
  forces.damping = 60.0;
  double velocity = 0.0;
  for (int i = 0; i < 5000; ++i)
    velocity = slide_velocity(forces, 4.0, velocity, 0.001, std::nullopt).velocity;
  EXPECT_NEAR(velocity, -42.1 / 60.0, 1e-9);
}

TEST(Slide, CoulombFrictionSticksUpToItsLimitAndNoFurther) {
  SlideForces forces;
  forces.weight = 42.1;
  forces.coulomb = 3.5;
  forces.soil = 42.1 - 3.4;
  SlideVelocity still = slide_velocity(forces, 4.0, 0.0, 0.001, std::nullopt);
  EXPECT_EQ(still.velocity, 0.0);
  EXPECT_NEAR(still.friction, 3.4, 1e-12);  // it holds the slide up
  forces.soil = 42.1 - 3.6;
  const SlideVelocity moving = slide_velocity(forces, 4.0, 0.0, 0.001, std::nullopt);
  EXPECT_NEAR(moving.velocity, -0.1 / 4.0 * 0.001, 1e-15);
  EXPECT_EQ(moving.friction, 3.5);
}

TEST(Slide, FrictionStopsAMovingSlideWhereItsEnergyIsSpent) {
  // v0^2 / (2 a), a = coulomb / m, on a level guide (weight carried by the soil).
  SlideForces forces;
  forces.weight = 42.1;
  forces.soil = 42.1;
  forces.coulomb = 2.0;
  double velocity = 0.1, travel = 0.0;
  const double dt = 1e-5;
  for (int i = 0; i < 100000 && velocity != 0.0; ++i) {
    velocity = slide_velocity(forces, 4.0, velocity, dt, std::nullopt).velocity;
    travel += velocity * dt;
  }
  EXPECT_EQ(velocity, 0.0);
  EXPECT_NEAR(travel, 0.1 * 0.1 / (2.0 * 2.0 / 4.0), 2.0 * 0.1 * dt);  // first order in the step
}

TEST(Slide, TheHoistHoldsAndNeverPushes) {
  SlideForces forces;
  forces.weight = 42.1;
  const SlideVelocity held = slide_velocity(forces, 4.0, 0.0, 0.1, -0.01);
  EXPECT_TRUE(held.held);
  EXPECT_EQ(held.velocity, -0.01);
  forces.soil = 50.0;
  EXPECT_FALSE(slide_velocity(forces, 4.0, 0.0, 0.1, -0.01).held);
}

HubLoad spring(double height, double stiffness) {
  HubLoad load;
  load.force_hub_rig.z() = std::max(0.0, -stiffness * height);
  load.vertical_stiffness = height < 0.0 ? stiffness : 0.0;
  return load;
}

TEST(SlideEquilibrium, CarriesTheWeight) {
  for (const double start : {0.02, 0.0, -0.001, -0.05}) {
    const SlideEquilibrium found =
        slide_equilibrium([](double z) { return spring(z, 4000.0); }, start, 42.1, 0.0, -0.1);
    EXPECT_NEAR(found.height, -42.1 / 4000.0, 1e-6 * 42.1 / 4000.0) << "from " << start;
  }
}

TEST(SlideEquilibrium, FrictionHoldsOrLetsGoToItsLimit) {
  const auto soil = [](double z) { return spring(z, 4000.0); };
  const double rest = -42.1 / 4000.0;
  const SlideEquilibrium held = slide_equilibrium(soil, rest - 0.0005, 42.1, 3.5, -0.1);  // 2 N off: sticks
  EXPECT_EQ(held.height, rest - 0.0005);
  EXPECT_NEAR(held.friction, -2.0, 1e-9);
  const SlideEquilibrium up = slide_equilibrium(soil, rest - 0.01, 42.1, 3.5, -0.1);  // too low: moves up
  EXPECT_NEAR(up.load.force_hub_rig.z(), 42.1 + 3.5, 1e-4);
  const SlideEquilibrium down = slide_equilibrium(soil, rest + 0.005, 42.1, 3.5, -0.1);
  EXPECT_NEAR(down.load.force_hub_rig.z(), 42.1 - 3.5, 1e-4);
}

TEST(SlideEquilibrium, SaysWhenTheSoilCannotCarry) {
  EXPECT_THROW(slide_equilibrium([](double z) { return spring(z, 100.0); }, 0.0, 42.1, 0.0, -0.1), Error);
  EXPECT_THROW(slide_equilibrium([](double) { return spring(NAN, 1.0); }, 0.0, 42.1, 0.0, -0.1), Error);
}

}  // namespace
}  // namespace wheel_twin::rig
