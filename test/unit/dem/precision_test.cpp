// Where single precision is used (the contact law, its springs, levers and the velocities that contacts read)
// it is safe: against the same law in double precision, from another origin, and over a million steps.
#include <gmock/gmock.h>

#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

constexpr double kRestitution = 0.5;
constexpr double kFriction = 0.5;

/// A ball on the floor z = 0, law and leapfrog of doc/physics.md in double precision, motion in the plane
/// x-z.
struct DoubleBall {
  double x = 0.0, z = 0.0, vx = 0.0, vz = 0.0, spin = 0.0;  ///< velocities at half steps; spin about y
  double force_x = 0.0, force_z = 0.0, torque = 0.0, spring = 0.0, overlap = 0.0;

  double mass = 2759.0 * 4.0 / 3.0 * M_PI * std::pow(kRadius, 3);
  double inertia = 0.4 * mass * kRadius * kRadius;
  double youngs =
      1.0 / ((1.0 - 0.25 * 0.25) / soil().youngs_modulus() + (1.0 - 0.29 * 0.29) / steel().youngs_modulus());
  double shear = 1.0 / ((2.0 - 0.25) / soil().shear_modulus + (2.0 - 0.29) / steel().shear_modulus);
  double beta = std::log(kRestitution) / std::hypot(std::log(kRestitution), M_PI);

  void step(const Eigen::Vector3d& gravity, double dt) {
    vx += dt * (gravity.x() + force_x / mass);
    vz += dt * (gravity.z() + force_z / mass);
    spin += dt * torque / inertia;
    x += dt * vx;
    z += dt * vz;
    const double before = overlap;
    overlap = kRadius - z;
    if (overlap <= 0.0) {
      force_x = force_z = torque = spring = overlap = 0.0;
      return;
    }
    const double normal_stiffness = 2.0 * youngs * std::sqrt(kRadius * overlap);
    const double shear_stiffness = 8.0 * shear * std::sqrt(kRadius * overlap);
    const double damping = -2.0 * std::sqrt(5.0 / 6.0) * beta;
    const double normal_damping = damping * std::sqrt(normal_stiffness * mass);
    const double shear_damping = damping * std::sqrt(shear_stiffness * mass);
    force_z = 2.0 / 3.0 * normal_stiffness * overlap - normal_damping * vz;
    const double sliding = vx - z * spin;
    const double kept = spring * std::sqrt(std::min(1.0, before / overlap));
    const double trial = shear_stiffness * (kept + sliding * dt) + shear_damping * sliding;
    const double limit = kFriction * std::max(0.0, force_z);
    const double drag = std::clamp(trial, -limit, limit);
    spring = (drag + shear_damping / dt * kept) / (shear_stiffness + shear_damping / dt);
    force_x = -drag;
    torque = z * drag;
  }
};

TEST(Precision, AContactInSinglePrecisionFollowsTheSameLawInDouble) {
  // Bounces, slides, rolls down a slope for half a second and 50,000 steps.
  WorldSettings settings = empty_space(0.5);
  settings.gravity = {1.5, 0.0, -9.81};
  settings.time_step = 1e-5;
  System system(settings, table(kRestitution, kFriction, kFriction), {ball()});
  system.add_wall(floor_wall());
  system.add({at({-0.3, 0.0, kRadius + 2e-3}, {0.3, 0.0, 0.0})});
  DoubleBall reference;
  reference.x = -0.3;
  reference.z = kRadius + 2e-3;
  reference.vx = 0.3 - 0.5 * settings.time_step * settings.gravity.x();
  reference.vz = -0.5 * settings.time_step * settings.gravity.z();
  double worst_place = 0.0;
  double worst_speed = 0.0;
  for (int k = 0; k < 50000; ++k) {
    system.step();
    reference.step(settings.gravity, settings.time_step);
    if (k % 100 != 0) continue;
    const State state = system.state();
    worst_place = std::max({worst_place, std::fabs(state.position[0].x() - reference.x),
                            std::fabs(state.position[0].z() - reference.z)});
    worst_speed = std::max({worst_speed, std::fabs(state.velocity[0].x() - reference.vx),
                            std::fabs(state.velocity[0].z() - reference.vz)});
  }
  ASSERT_GT(reference.overlap, 0.0);
  EXPECT_GT(reference.vx, 0.7);
  EXPECT_LT(worst_place, 1e-8);
  // During a bounce the velocity turns within 0.1 ms: 1e-9 s of delay are 2e-6 m/s.
  EXPECT_LT(worst_speed, 5e-6);
  EXPECT_NEAR(system.state().velocity[0].x(), reference.vx, 1e-7 * reference.vx);
}

TEST(Precision, FarFromTheOriginIsTheSame) {
  // A kilometre away a centre is known to 1e-13 m, an overlap of 1e-6 m to 1e-7 of itself.
  const auto run = [](double away) {
    WorldSettings settings;
    settings.low = {away, -away, -0.01};
    settings.high = {away + 0.075, -away + 0.075, 0.2};
    settings.periodic_x = settings.periodic_y = true;
    settings.time_step = 1.77e-5;
    settings.smallest_size = 0.9;
    System system(settings, table(), {four(), lopsided()});
    system.add_wall(floor_wall());
    auto particles = cloud(6, 6, 3, 0.0125, 2, 12, 0.1);
    for (auto& p : particles) p.position += Eigen::Vector3d(away, -away, 0.0);
    system.add(particles);
    system.step(3000);
    int collided = 0;
    const auto after = system.particles();
    for (std::size_t k = 0; k < particles.size(); ++k) {
      const Eigen::Vector3d free = particles[k].velocity - Eigen::Vector3d(0.0, 0.0, 9.81 * system.time());
      if ((after[k].velocity - free).norm() > 1e-3) ++collided;
    }
    EXPECT_GT(collided, 50);
    return after;
  };
  const auto here = run(0.0);
  const auto there = run(1024.0);
  double worst = 0.0;
  for (std::size_t k = 0; k < here.size(); ++k) {
    Eigen::Vector3d d = there[k].position - here[k].position - Eigen::Vector3d(1024.0, -1024.0, 0.0);
    for (int a = 0; a < 2; ++a) d[a] -= 0.075 * std::round(d[a] / 0.075);
    worst = std::max(worst, d.norm());
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(Precision, NothingCreepsInAMillionSteps) {
  // Balls heaped on a slope for 18 s, held by friction and rolling resistance: springs in single precision
  // must not leak.
  MaterialTable materials = table(0.5, 0.9, 0.9);
  for (const std::uint32_t other : {0U, 1U}) {
    PairProperties pair = materials.pair(0, other);
    pair.rolling_friction = 0.5;
    materials.set_pair(0, other, pair);
  }
  WorldSettings settings = empty_space();
  settings.gravity = {9.81 * std::sin(0.2), 0.0, -9.81 * std::cos(0.2)};
  settings.time_step = 1.77e-5;
  System system(settings, materials, {ball()});
  system.add_wall(floor_wall());
  const double r = kRadius;
  const double across = 2.0 * r / std::sqrt(3.0);
  system.add({at({across, 0.0, r}), at({-0.5 * across, r, r}), at({-0.5 * across, -r, r}),
              at({0.0, 0.0, r * (1.0 + 2.0 * std::sqrt(2.0 / 3.0))})});
  system.step(100000);
  const std::vector<Particle> before = system.particles();
  system.step(1000000);
  const std::vector<Particle> after = system.particles();
  double worst = 0.0;
  for (std::size_t k = 0; k < before.size(); ++k)
    worst = std::max(worst, (after[k].position - before[k].position).norm());
  EXPECT_GT(system.contacts().size(), 2U);
  EXPECT_LT(worst, 1e-5 * kRadius);
}

}  // namespace
}  // namespace wheel_twin::dem::test
