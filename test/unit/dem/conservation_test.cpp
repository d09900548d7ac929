// What must not change: momentum, angular momentum, energy; and what must be the same from another point of
// view.
#include <gmock/gmock.h>

#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
  double scale = 0.0;  ///< sum of the magnitudes of the parts of the angular momentum
};

/// From the velocities and momenta at half steps, with the centres half a step back: what the leapfrog
/// conserves.
Momenta momenta(const System& system) {
  const State state = system.state();
  Momenta sum;
  for (std::size_t k = 0; k < state.position.size(); ++k) {
    const double mass = system.mass(k);
    sum.linear += mass * state.velocity[k];
    const Eigen::Vector3d orbital = mass * state.position[k].cross(state.velocity[k]);
    sum.angular += orbital + state.angular_momentum[k];
    sum.scale += orbital.norm() + state.angular_momentum[k].norm();
  }
  return sum;
}

TEST(Conservation, MomentaOfCollidingClumpsToRoundOff) {
  WorldSettings settings = empty_space(0.3);
  settings.time_step = 5e-6;
  settings.smallest_size = 0.9;
  System system(settings, table(), {lopsided(), four()});
  auto particles = cloud(4, 4, 4, 0.0125, 2, 7, 0.2);
  const Eigen::Vector3d middle(0.025, 0.025, 0.028);
  for (auto& p : particles) p.velocity -= 40.0 * (p.position - middle);  // they meet in the middle
  system.add(particles);
  const Momenta before = momenta(system);
  std::size_t most = 0;
  for (int k = 0; k < 320; ++k) {
    system.step(25);
    most = std::max(most, system.statistics().contacts);
  }
  const Momenta after = momenta(system);
  EXPECT_GT(most, 25U);
  double speed = 0.0;
  for (std::size_t k = 0; k < particles.size(); ++k) speed += system.mass(k) * particles[k].velocity.norm();
  // 8000 steps add 64 bodies' rounding errors of 2^-53 each as a random walk: below 1e-12 of the sum of
  // magnitudes.
  EXPECT_LT((after.linear - before.linear).norm(), 1e-12 * speed);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-12 * before.scale);
}

TEST(Conservation, TorqueFreeAsymmetricClumpOverAMillionSteps) {
  WorldSettings settings = empty_space();
  settings.time_step = 1.77e-5;
  System system(settings, table(), {lopsided()});
  Particle p = at({0.0, 0.0, 0.0});
  p.orientation = Eigen::Quaterniond(0.5, 0.1, -0.7, 0.5).normalized();
  // Mostly about the middle axis, which is unstable: it tumbles. 60 rad/s is fast for a grain of 5 mm.
  p.angular_velocity = p.orientation * Eigen::Vector3d(0.6, 60.0, 0.6);
  system.add({p});
  const double energy = system.energy().kinetic;
  const Eigen::Vector3d momentum = system.state().angular_momentum[0];
  double largest = 0.0;
  double smallest_turn = 1.0;
  for (int k = 0; k < 1000; ++k) {
    system.step(1000);
    largest = std::max(largest, std::fabs(system.energy().kinetic / energy - 1.0));
    const Eigen::Vector3d body = system.particle(0).orientation.conjugate() * momentum.normalized();
    smallest_turn = std::min(smallest_turn, body.y());
  }
  EXPECT_EQ(system.state().angular_momentum[0], momentum);
  // Second order in (w dt)^2 = 1e-6, bounded: the splitting is symplectic.
  EXPECT_LT(largest, 1e-6);
  EXPECT_LT(smallest_turn, -0.9) << "the middle axis turned over";
}

TEST(Conservation, RotationConvergesWithTheSecondOrder) {
  const auto turned = [](double step, int count) {
    WorldSettings settings = empty_space();
    settings.time_step = step;
    System system(settings, table(), {lopsided()});
    Particle p;
    p.angular_velocity = {300.0, 500.0, -200.0};
    system.add({p});
    system.step(count);
    return system.particle(0).orientation;
  };
  const Eigen::Quaterniond exact = turned(2e-7, 40000);
  const double coarse = turned(1.6e-5, 500).angularDistance(exact);
  const double fine = turned(8e-6, 1000).angularDistance(exact);
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);
  EXPECT_LT(fine, 1e-4);
}

TEST(Conservation, ProjectileIsExact) {
  // The leapfrog integrates constant acceleration without error; what is left is round-off.
  WorldSettings settings = empty_space(2.0);
  settings.gravity = {0.3, -0.2, -1.62};
  settings.time_step = 1e-5;
  System system(settings, table(), {four()});
  system.add({at({0.0, 0.0, 0.0}, {0.5, 0.2, 0.4})});
  system.step(50000);
  const double t = system.time();
  const Eigen::Vector3d expected = t * Eigen::Vector3d(0.5, 0.2, 0.4) + 0.5 * t * t * settings.gravity;
  EXPECT_LT((system.particle(0).position - expected).norm(), 1e-11);
  EXPECT_LT((system.particle(0).velocity - Eigen::Vector3d(0.5, 0.2, 0.4) - t * settings.gravity).norm(),
            1e-11);
}

TEST(Conservation, EnergyBookClosesWhileClumpsFallAndSettle) {
  WorldSettings settings = booked_column();
  System system(settings, table(), {four(), lopsided()});
  system.add_wall(floor_wall());
  system.add(cloud(5, 5, 4, 0.012, 2, 9, 0.2));
  const EnergyBook before = system.energy();
  double worst = 0.0;
  EnergyBook last = before;
  for (int k = 0; k < 60; ++k) {
    system.step(500);
    const EnergyBook now = system.energy();
    worst = std::max(worst, std::fabs(total(now) - total(before)));
    EXPECT_GE(now.friction, last.friction);
    last = now;
  }
  const double turnover = last.damped + last.friction;
  EXPECT_GT(last.damped, 0.1 * turnover);
  EXPECT_GT(last.friction, 0.1 * turnover);
  EXPECT_LT(worst, 1e-3 * turnover);
}

TEST(Conservation, EnergyBookClosesWithAMovingWall) {
  WorldSettings settings;
  settings.low = {0.0, 0.0, -0.01};
  settings.high = {0.048, 0.048, 0.2};
  settings.periodic_x = settings.periodic_y = true;
  settings.time_step = 5e-6;
  settings.smallest_size = 0.9;
  settings.track_energy = true;
  System system(settings, table(), {four()});
  const auto ground = system.add_wall(floor_wall());
  system.add(cloud(4, 4, 3, 0.012, 1, 10, 0.05));
  system.step(30000);
  const EnergyBook before = system.energy();
  Motion motion;
  motion.velocity = {0.1, 0.0, 0.02};
  system.set_wall_motion(ground, motion);
  system.step(20000);
  const EnergyBook after = system.energy();
  const double work = after.wall_work - before.wall_work;
  EXPECT_GT(work, 0.0);
  EXPECT_LT(std::fabs(total(after) - total(before)), 1e-3 * work);
}

TEST(Conservation, WeightOnTheFloor) {
  System system = box_of(6, 6, 0.2, 0.0125, {four(), lopsided()});
  system.add(cloud(6, 6, 5, 0.0125, 2, 11, 0.05));
  double weight = 0.0;
  for (std::size_t k = 0; k < system.size(); ++k) weight += 9.81 * system.mass(k);
  system.step(40000);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int k = 0; k < 4000; ++k) {
    system.step();
    mean += system.wall_wrench(0).force / 4000.0;
  }
  EXPECT_NEAR(-mean.z(), weight, 1e-3 * weight);
  EXPECT_LT(std::hypot(mean.x(), mean.y()), 1e-3 * weight);
}

TEST(Conservation, PeriodicImagesAreTheSame) {
  // The same cloud shifted by whole lattice sites around the period: the same motion up to round-off.
  const double spacing = 0.0125;
  const auto particles = cloud(6, 6, 3, spacing, 2, 12, 0.1);
  const auto run = [&](int sites_x, int sites_y) {
    System system = box_of(6, 6, 0.2, spacing, {four(), lopsided()});
    auto moved = particles;
    for (auto& p : moved) {
      p.position.x() = std::fmod(p.position.x() + sites_x * spacing, 6 * spacing);
      p.position.y() = std::fmod(p.position.y() + sites_y * spacing, 6 * spacing);
    }
    system.add(moved);
    system.step(3000);
    return system.particles();
  };
  const auto here = run(0, 0);
  const auto there = run(2, 5);
  double worst = 0.0;
  for (std::size_t k = 0; k < here.size(); ++k) {
    Eigen::Vector3d d = there[k].position - here[k].position;
    d.x() -= 2 * spacing;
    d.y() -= 5 * spacing;
    for (int a = 0; a < 2; ++a) d[a] -= 6 * spacing * std::round(d[a] / (6 * spacing));
    worst = std::max(worst, d.norm());
  }
  // Round-off of 1e-17 m, grown by the chaos of some collisions in 53 ms; single precision in the levers and
  // springs.
  EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace wheel_twin::dem::test
