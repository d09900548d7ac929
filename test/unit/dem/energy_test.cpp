// The energy book with everything that may enter it: rolling friction, cohesion, gravity along the period,
// rolling against a turning wall.
#include <gmock/gmock.h>

#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

MaterialTable rolling_table(double rolling) {
  MaterialTable materials = table();
  for (const std::uint32_t other : {0U, 1U}) {
    PairProperties pair = materials.pair(0, other);
    pair.rolling_friction = rolling;
    materials.set_pair(0, other, pair);
  }
  return materials;
}

/// Largest departure of the total from its start over `blocks` times 500 steps, J.
double departure(System& system, int blocks) {
  const double before = total(system.energy());
  double worst = 0.0;
  for (int k = 0; k < blocks; ++k) {
    system.step(500);
    worst = std::max(worst, std::fabs(total(system.energy()) - before));
  }
  return worst;
}

TEST(Energy, BookClosesWithRollingFriction) {
  for (const double rolling : {0.1, 0.4}) {
    System system(booked_column(), rolling_table(rolling), {four(), ball()});
    system.add_wall(floor_wall());
    system.add(cloud(5, 5, 4, 0.012, 2, 9, 0.2));
    const double worst = departure(system, 60);
    const EnergyBook book = system.energy();
    EXPECT_GT(book.friction, 0.1 * book.damped);
    EXPECT_LT(worst, 1e-3 * (book.damped + book.friction)) << "rolling friction " << rolling;
  }
}

TEST(Energy, RollingResistanceTakesWhatABallLoses) {
  // A ball that rolls to a stop: friction has taken all of it, 7/10 m v^2.
  WorldSettings settings = booked_column();
  System system(settings, rolling_table(0.1), {ball()});
  system.add_wall(floor_wall());
  system.add({at({0.02, 0.02, kRadius - 1.2e-6})});
  system.step(20000);
  const double speed = 0.1;
  system.set_velocity(0, {speed, 0.0, 0.0}, {0.0, speed / kRadius, 0.0});
  const EnergyBook before = system.energy();
  system.step(50000);
  const EnergyBook after = system.energy();
  const double kinetic = 0.7 * system.mass(0) * speed * speed;
  EXPECT_NEAR(before.kinetic, kinetic, 1e-3 * kinetic);
  EXPECT_LT(after.kinetic, 1e-3 * kinetic);
  EXPECT_NEAR(after.friction - before.friction, kinetic, 5e-3 * kinetic);
}

TEST(Energy, ATurningWallWorksAgainstRollingResistance) {
  // A plate that slides and turns under balls drags and rolls them: its work is in the book.
  System system(booked_column(), rolling_table(0.2), {ball()});
  const auto ground = system.add_wall(floor_wall());
  system.add(cloud(4, 4, 2, 0.0135, 1, 3, 0.05));
  system.step(30000);
  const EnergyBook before = system.energy();
  Motion motion;
  motion.velocity = {0.05, 0.0, 0.01};
  motion.angular_velocity = {0.0, 0.0, 3.0};
  system.set_wall_motion(ground, motion);
  const double worst = departure(system, 40);
  const double work = system.energy().wall_work - before.wall_work;
  EXPECT_GT(work, 0.0);
  EXPECT_LT(worst, 1e-3 * work);
}

TEST(Energy, BookClosesDownASlopeAroundThePeriod) {
  // Grains flow down a slope of 50 degrees and cross the period again and again.
  WorldSettings settings = booked_column();
  const double slope = 50.0 * M_PI / 180.0;
  settings.gravity = {9.81 * std::sin(slope), 2.0, -9.81 * std::cos(slope)};
  System system(settings, table(0.5, 0.3, 0.3), {four(), lopsided()});
  system.add_wall(floor_wall());
  system.add(cloud(5, 5, 3, 0.012, 2, 9, 0.05));
  const double worst = departure(system, 100);
  const EnergyBook book = system.energy();
  double fastest = 0.0;
  for (const auto& p : system.particles()) fastest = std::max(fastest, p.velocity.x());
  EXPECT_GT(fastest, 0.5);
  EXPECT_LT(worst, 1e-3 * (book.damped + book.friction));
}

TEST(Energy, BookClosesWithCohesion) {
  MaterialTable materials = table();
  PairProperties pair = materials.pair(0, 0);
  pair.cohesion_energy_density = 2e4;
  materials.set_pair(0, 0, pair);
  System system(booked_column(), materials, {four()});
  system.add_wall(floor_wall());
  system.add(cloud(5, 5, 4, 0.012, 1, 9, 0.2));
  const double worst = departure(system, 60);
  const EnergyBook book = system.energy();
  EXPECT_LT(worst, 1e-3 * (book.damped + book.friction));
}

}  // namespace
}  // namespace wheel_twin::dem::test
