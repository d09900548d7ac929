// Two-body problems with closed forms.
#include <gmock/gmock.h>

#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

double mass_of_ball(double radius = kRadius) {
  return 2759.0 * 4.0 / 3.0 * M_PI * std::pow(radius, 3);
}

/// E_eq of soil against soil (or steel).
double modulus(const Material& a, const Material& b) {
  return 1.0 / ((1.0 - a.poisson_ratio * a.poisson_ratio) / a.youngs_modulus() +
                (1.0 - b.poisson_ratio * b.poisson_ratio) / b.youngs_modulus());
}

/// Two balls along x towards each other with relative speed v, `step` s. Returns the system before the first
/// touch.
System head_on(double v, double restitution, double step) {
  WorldSettings settings = empty_space();
  settings.time_step = step;
  System system(settings, table(restitution), {ball()});
  const double gap = 0.2 * v * step;
  system.add({at({-kRadius - 0.5 * gap, 0.0, 0.0}, {0.5 * v, 0.0, 0.0}),
              at({kRadius + 0.5 * gap, 0.0, 0.0}, {-0.5 * v, 0.0, 0.0})});
  return system;
}

/// Duration of an undamped Hertz contact: 2.94 (m*^2 / (k^2 v))^(1/5) with k = 16/15 E* sqrt(R*): 2.9432
/// d_max / v (Johnson, Contact Mechanics, 1985, Section 11.4).
double hertz_time(double m_eq, double r_eq, double e_eq, double v) {
  const double deepest = std::pow(15.0 * m_eq * v * v / (16.0 * e_eq * std::sqrt(r_eq)), 0.4);
  return 2.9432 * deepest / v;
}

TEST(Contact, RestitutionComesBackOverTwoDecadesOfSpeed) {
  // With sqrt(5/6) and Hertz stiffness Tsuji's damping gives e exactly, at every speed (Antypov and Elliott
  // 2011).
  for (const double e : {0.5, 0.8}) {
    for (const double v : {0.01, 0.1, 1.0}) {
      const double contact = hertz_time(0.5 * mass_of_ball(), 0.5 * kRadius, modulus(soil(), soil()), v);
      System system = head_on(v, e, contact / 400.0);
      system.step(1200);
      const double rebound = system.particle(1).velocity.x() - system.particle(0).velocity.x();
      EXPECT_NEAR(rebound / v, e, 0.01 * e) << "e " << e << " at " << v << " m/s";
    }
  }
}

TEST(Contact, RestitutionAtTheStepOfTheBeds) {
  // 1.77e-5 s resolves the contact of 1 m/s in about 16 steps; the error of the leapfrog stays within 3 %.
  System system = head_on(0.1, 0.5, 1.77e-5);
  system.step(200);
  EXPECT_NEAR((system.particle(1).velocity.x() - system.particle(0).velocity.x()) / 0.1, 0.5, 0.015);
}

TEST(Contact, HertzContactTime) {
  const double v = 0.2;
  const double expected = hertz_time(0.5 * mass_of_ball(), 0.5 * kRadius, modulus(soil(), soil()), v);
  const double step = expected / 2000.0;
  System system = head_on(v, 1.0, step);
  int touching = 0;
  for (int k = 0; k < 3000; ++k) {
    system.step();
    if (system.loads()[0].force.norm() > 0.0) ++touching;
  }
  EXPECT_NEAR(touching * step, expected, 0.002 * expected);
  EXPECT_NEAR(system.particle(1).velocity.x() - system.particle(0).velocity.x(), v, 1e-4 * v);
}

TEST(Contact, DeepestOverlapOfAWallImpact) {
  // Sphere on a stiff half-space: 1/2 m v^2 = 8/15 E* sqrt(R) d^2.5.
  WorldSettings settings = empty_space();
  settings.time_step = 5e-7;
  System system(settings, table(1.0), {ball()});
  system.add_wall(floor_wall());
  const double v = 0.1;
  system.add({at({0.0, 0.0, kRadius + 1e-7}, {0.0, 0.0, -v})});
  double lowest = 1.0;
  for (int k = 0; k < 2000; ++k) {
    system.step();
    lowest = std::min(lowest, system.particle(0).position.z());
  }
  const double e_eq = modulus(soil(), steel());
  const double expected = std::pow(15.0 * mass_of_ball() * v * v / (16.0 * e_eq * std::sqrt(kRadius)), 0.4);
  EXPECT_NEAR(kRadius - lowest, expected, 1e-3 * expected);
}

/// A ball hits the floor obliquely. Returns (normal and tangential rebound speed, spin) for speed v.
Particle oblique_impact(double angle, double v, double restitution, double friction) {
  WorldSettings settings = empty_space();
  settings.time_step = 2.5e-7;
  System system(settings, table(restitution, friction, friction), {ball()});
  system.add_wall(floor_wall());
  system.add({at({0.0, 0.0, kRadius + 1e-8}, {v * std::sin(angle), 0.0, -v * std::cos(angle)})});
  system.step(6000);
  EXPECT_EQ(system.loads()[0].force.norm(), 0.0);
  return system.particle(0);
}

TEST(Contact, ObliqueImpactThatSlidesThroughout) {
  // Gross sliding: tangential impulse = mu (1 + e) m v_n, spin R that / I (e.g. Walton 1993; Thornton et al.
  // 2013).
  const double mu = 0.2;
  const double e = 0.8;
  const double v = 0.5;
  for (const double degrees : {55.0, 65.0, 75.0}) {
    const double angle = degrees * M_PI / 180.0;
    const Particle out = oblique_impact(angle, v, e, mu);
    const double vn = v * std::cos(angle);
    EXPECT_NEAR(out.velocity.z(), e * vn, 0.01 * e * vn);
    const double impulse = mu * (1.0 + e) * vn;  // a unit of mass
    EXPECT_NEAR(out.velocity.x(), v * std::sin(angle) - impulse, 0.01 * impulse) << degrees;
    EXPECT_NEAR(out.angular_velocity.y(), 2.5 * impulse / kRadius, 0.01 * 2.5 * impulse / kRadius) << degrees;
  }
}

TEST(Contact, ObliqueImpactIsMirroredByTheOtherDirection) {
  WorldSettings settings = empty_space();
  settings.time_step = 1e-6;
  const auto run = [&](double sign) {
    System system(settings, table(), {ball()});
    system.add_wall(floor_wall());
    system.add({at({0.0, 0.0, kRadius + 1e-8}, {sign * 0.3, 0.0, -0.3})});
    system.step(1500);
    return system.particle(0);
  };
  const Particle right = run(1.0);
  const Particle left = run(-1.0);
  EXPECT_EQ(right.velocity.x(), -left.velocity.x());
  EXPECT_EQ(right.angular_velocity.y(), -left.angular_velocity.y());
}

TEST(Contact, SlidingTurnsIntoRollingAtFiveSeventhsOfTheSpeed) {
  WorldSettings settings = empty_space(0.4);
  settings.gravity = {0.0, 0.0, -9.81};
  settings.time_step = 1e-5;
  const double mu = 0.3;
  System system(settings, table(0.2, mu, mu), {ball()});
  system.add_wall(floor_wall());
  const double v = 0.5;
  const double load = mass_of_ball() * 9.81;
  const double overlap =
      std::pow(load / (4.0 / 3.0 * modulus(soil(), steel()) * std::sqrt(kRadius)), 2.0 / 3.0);
  system.add({at({-0.3, 0.0, kRadius - overlap}, {v, 0.0, 0.0})});
  // It slides for 2 v / (7 mu g), losing mu g (Coriolis).
  const double slides = 2.0 * v / (7.0 * mu * 9.81);
  system.step(static_cast<int>(0.5 * slides / settings.time_step));
  EXPECT_NEAR(system.particle(0).velocity.x(), v - 0.5 * mu * 9.81 * slides, 0.005 * v);
  system.step(static_cast<int>(1.5 * slides / settings.time_step));
  EXPECT_NEAR(system.particle(0).velocity.x(), 5.0 / 7.0 * v, 0.005 * v);
  EXPECT_NEAR(system.particle(0).angular_velocity.y() * kRadius, 5.0 / 7.0 * v, 0.005 * v);
}

TEST(Contact, StaysOnASlopeBelowTheFrictionAngleAndAcceleratesAbove) {
  // A four-sphere clump rests on the floor under a tilted gravity: a block on a slope.
  const double mu = 0.5;
  for (const double degrees : {20.0, 35.0}) {
    WorldSettings settings = empty_space(0.5);
    settings.gravity = {0.0, 0.0, -9.81};
    settings.time_step = 1e-5;
    const ClumpTemplate plate = make_clump("plate", {{{0.006, 0.006, 0.0}, kRadius},
                                                     {{-0.006, 0.006, 0.0}, kRadius},
                                                     {{0.006, -0.006, 0.0}, kRadius},
                                                     {{-0.006, -0.006, 0.0}, kRadius},
                                                     {{0.0, 0.0, 0.004}, 0.0065}});
    System system(settings, table(0.3, 0.9, mu), {plate});
    system.add_wall(floor_wall(-0.003));
    // The four feet down, whatever the principal axes.
    const auto& feet = plate.spheres;
    Eigen::Vector3d up = (feet[1].center - feet[0].center).cross(feet[2].center - feet[0].center);
    if (up.dot(feet[4].center - feet[0].center) < 0.0) up = -up;
    Particle block = at({-0.2, 0.0, 0.004});
    block.orientation = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
    system.add({block});
    system.step(30000);
    const double slope = degrees * M_PI / 180.0;
    system.set_gravity({9.81 * std::sin(slope), 0.0, -9.81 * std::cos(slope)});
    system.stop_all();
    system.step(2000);
    const double before = system.particle(0).velocity.x();
    system.step(5000);
    const double acceleration = (system.particle(0).velocity.x() - before) / 0.05;
    const double expected = degrees < 26.0 ? 0.0 : 9.81 * (std::sin(slope) - mu * std::cos(slope));
    EXPECT_NEAR(acceleration, expected, 0.01 * 9.81) << degrees << " degrees";
  }
}

TEST(Contact, RollingResistanceHoldsABallOnASlope) {
  // Held while tan(slope) < mu_r (Ai et al. 2011); rolls above.
  for (const double slope : {0.05, 0.15}) {
    MaterialTable materials = table(0.3, 0.9, 0.5);
    PairProperties pair = materials.pair(0, 1);
    pair.rolling_friction = 0.1;
    materials.set_pair(0, 1, pair);
    WorldSettings settings = empty_space(0.3);
    settings.gravity = {9.81 * std::sin(slope), 0.0, -9.81 * std::cos(slope)};
    settings.time_step = 1e-5;
    System system(settings, materials, {ball()});
    system.add_wall(floor_wall());
    system.add({at({-0.2, 0.0, kRadius - 1.5e-6})});
    system.step(30000);
    const double before = system.particle(0).velocity.x();
    system.step(5000);
    const double acceleration = (system.particle(0).velocity.x() - before) / 0.05;
    const double expected = slope < 0.1 ? 0.0 : 5.0 / 7.0 * 9.81 * (std::sin(slope) - 0.1 * std::cos(slope));
    EXPECT_NEAR(acceleration, expected, 0.003 * 9.81) << slope;
  }
}

TEST(Contact, CohesionHoldsTheWeightOfABall) {
  // Simplified JKR pulls with k 2 pi R_eq d; hanging from a ceiling, the ball stays where Hertz, weight and
  // pull balance: k 2 pi R d = m g + 4/3 E sqrt(R) d^1.5, which has a solution only when k is large enough.
  const double b = 4.0 / 3.0 * modulus(soil(), steel()) * std::sqrt(kRadius);
  const auto stays = [&](double energy_density) {
    const double a = energy_density * 2.0 * M_PI * kRadius;
    MaterialTable materials = table();
    PairProperties pair = materials.pair(0, 1);
    pair.cohesion_energy_density = energy_density;
    materials.set_pair(0, 1, pair);
    WorldSettings settings = empty_space(0.1);
    settings.gravity = {0.0, 0.0, -9.81};
    settings.time_step = 1e-5;
    System system(settings, materials, {ball()});
    Wall ceiling = floor_wall(0.0);
    ceiling.shape = HalfSpace{{0.0, 0.0, -1.0}};
    system.add_wall(ceiling);
    system.add({at({0.0, 0.0, -kRadius + 0.8 * (a / b) * (a / b)})});
    try {
      system.step(9000);
    } catch (const std::exception&) {
      return false;
    }
    return system.particle(0).position.z() > -kRadius;
  };
  // Largest net pull over d: with a = k 2 pi R, b = 4/3 E sqrt(R): 4 a^3 / (27 b^2) = m g.
  const double needed = std::cbrt(27.0 / 4.0 * b * b * mass_of_ball() * 9.81) / (2.0 * M_PI * kRadius);
  EXPECT_FALSE(stays(0.9 * needed));
  EXPECT_TRUE(stays(1.3 * needed));
}

TEST(Contact, FurtherLawsThatAreSwitchedOffChangeNothing) {
  // The kernel with rolling and cohesion, both zero for this pair, against the plain one: same bits.
  const auto run = [](bool with) {
    MaterialTable materials = table();
    materials.add({"other", 1000.0, 1e7, 0.2});
    if (with) {
      PairProperties pair;
      pair.rolling_friction = 0.3;
      pair.cohesion_energy_density = 100.0;
      materials.set_pair(1, 2, pair);
    }
    System system(empty_space(), materials, {ball()});
    system.add({at({-kRadius, 0.0, 0.0}, {0.1, 0.0, 0.0}), at({kRadius, 0.001, 0.0}, {-0.1, 0.0, 0.0})});
    system.step(2000);
    return system.particle(1).velocity;
  };
  EXPECT_EQ(run(false), run(true));
}

}  // namespace
}  // namespace wheel_twin::dem::test
