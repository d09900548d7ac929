// Oblique elastic impact of a ball on a floor: sticking, micro-slip and sliding.
//
// psi_1 = kappa v_x / (mu v_z) before and psi_2 after the impact, of the surface's velocity at the contact
// point, kappa = S_t / S_n = 4 G / E (Maw, Barber and Fawcett, Wear 38, 1976, in the notation of Johnson,
// Contact Mechanics, 1985, Section 11.4).
#include <gmock/gmock.h>

#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

constexpr double kNormalSpeed = 0.02;  // m/s: overlaps of a thousandth of the radius

struct Pairing {
  double poisson = 0.25;
  double friction = 0.3;
};

Material grain(double poisson) {
  Material material = soil();
  material.poisson_ratio = poisson;
  return material;
}

double shear_ratio(double poisson) {
  const auto compliance = [](const Material& m) {
    return std::pair((1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus(),
                     (2.0 - m.poisson_ratio) / m.shear_modulus);
  };
  const auto [normal_a, tangential_a] = compliance(grain(poisson));
  const auto [normal_b, tangential_b] = compliance(steel());
  return 4.0 * (normal_a + normal_b) / (tangential_a + tangential_b);
}

/// Velocity of the surface after the impact over that before it.
double rebound(const Pairing& pairing, double speed_x) {
  MaterialTable materials;
  const auto ball_material = materials.add(grain(pairing.poisson));
  const auto wall = materials.add(steel());
  PairProperties pair;
  pair.restitution = 1.0;
  pair.friction = pairing.friction;
  materials.set_pair(ball_material, ball_material, pair);
  materials.set_pair(ball_material, wall, pair);
  WorldSettings settings = empty_space();
  settings.time_step = 2e-7;
  System system(settings, materials, {ball()});
  system.add_wall(floor_wall());
  system.add({at({0.0, 0.0, kRadius + 1e-9}, {speed_x, 0.0, -kNormalSpeed})});
  do system.step(100);
  while (system.loads()[0].force.norm() > 0.0);
  const Particle after = system.particle(0);
  EXPECT_NEAR(after.velocity.z(), kNormalSpeed, 1e-3 * kNormalSpeed);
  return (after.velocity.x() - kRadius * after.angular_velocity.y()) / speed_x;
}

/// Sticking throughout. With z = (d / d_max)^(5/2) Hertz's and Mindlin's stiffness give for the surface's
/// velocity u while loading (dF_t = S_t dx), and for the spring while unloading (F_t = S_t xi), one
/// hypergeometric equation with a + b = 1/10, a b = -3/10 lambda, c = 3/5, lambda = 7/2 kappa; its values at
/// the ends follow from Gauss's theorem and the connection formula (Abramowitz and Stegun 15.1.20, 15.3.6).
double sticking_rebound(double kappa) {
  const double lambda = 3.5 * kappa;
  const double root = std::sqrt(0.01 + 1.2 * lambda);
  const double a = 0.5 * (0.1 + root);
  const double b = 0.5 * (0.1 - root);
  const double force = std::tgamma(0.6) * std::tgamma(-0.5) / (std::tgamma(a) * std::tgamma(b));
  const double speed = std::tgamma(0.6) * std::tgamma(0.5) / (std::tgamma(0.6 - a) * std::tgamma(0.6 - b));
  const double spring = 2.0 / (3.0 * lambda) * force;
  return -std::tgamma(-0.4) *
         (spring * std::tgamma(0.5) / (std::tgamma(a) * std::tgamma(b)) +
          0.8 * speed * std::tgamma(1.5) / (std::tgamma(0.6 - a) * std::tgamma(0.6 - b)));
}

/// psi_2 of Maw, Barber and Fawcett's solution, which has micro-slip, by the exact mapping to a row of
/// independent springs (method of dimensionality reduction; Lyashenko and Popov, Scientific Reports 5, 2015).
/// Lengths in d_max across and sqrt(R d_max) along the surface, speeds in v_z, friction 1.
double with_micro_slip(double psi_1, double kappa) {
  constexpr int kSprings = 400;
  constexpr int kSteps = 4000;
  const double dt = 2.9432 / kSteps;
  std::vector<double> stretch(kSprings, 0.0);
  double depth = 0.0;
  double normal_speed = 1.0;
  double speed = psi_1 / kappa;
  for (;;) {
    depth += normal_speed * dt;
    if (depth <= 0.0) return kappa * speed;
    double sum = 0.0;
    for (int k = 0; k < kSprings; ++k) {
      const double x = (k + 0.5) / kSprings;
      const double pressed = std::max(0.0, depth - x * x);
      stretch[k] =
          std::clamp(pressed > 0.0 ? stretch[k] + speed * dt : 0.0, -pressed / kappa, pressed / kappa);
      sum += stretch[k];
    }
    normal_speed -= 1.25 * std::pow(depth, 1.5) * dt;
    speed -= 3.5 * kappa * 15.0 / 16.0 * sum * 2.0 / kSprings * dt;
  }
}

double psi_2(double psi_1, const Pairing& pairing) {
  const double kappa = shear_ratio(pairing.poisson);
  const double speed_x = psi_1 * pairing.friction * kNormalSpeed / kappa;
  return rebound(pairing, speed_x) * psi_1;
}

TEST(ObliqueImpact, SticksAsMindlinsSpringWithoutSlip) {
  // Friction so large that only the very end slips. The lever shrinks by the overlap: 0.2 %.
  for (const double poisson : {0.0, 0.25, 0.4}) {
    const double expected = sticking_rebound(shear_ratio(poisson));
    EXPECT_NEAR(rebound({poisson, 10.0}, 0.3 * kNormalSpeed), expected, 0.005)
        << "Poisson's ratio " << poisson;
  }
}

TEST(ObliqueImpact, SlidesThroughoutFromWhereTheSpringUnloadsFaster) {
  // At the end of the impact the spring of a sliding contact shortens with 2/3 mu v_z / kappa here (F_t = S_t
  // xi), with mu v_z / kappa in Mindlin's contact, where psi_1 = 4 chi - 1 = 7 kappa - 1 is the limit (Maw et
  // al. 1976). Sliding throughout changes psi by 7 kappa.
  const Pairing pairing;
  const double kappa = shear_ratio(pairing.poisson);
  const double limit = 7.0 * kappa - 2.0 / 3.0;
  for (const double psi_1 : {limit + 0.1, limit + 2.0})
    EXPECT_NEAR(psi_2(psi_1, pairing), psi_1 - 7.0 * kappa, 0.002 * 7.0 * kappa) << psi_1;
  for (const double psi_1 : {limit - 0.4, limit - 1.0})
    EXPECT_GT(psi_2(psi_1, pairing), psi_1 - 7.0 * kappa + 0.01) << psi_1;
}

TEST(ObliqueImpact, LeavingMicroSlipOutCostsWhatTheValidationSays) {
  // One spring a contact instead of stick and slip side by side: the surface comes back with more of its
  // velocity where it sticks, less where it slides first. doc/validation.md has the numbers.
  const Pairing pairing;
  const double kappa = shear_ratio(pairing.poisson);
  double largest = 0.0;
  for (const double psi_1 : {0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
    const double here = psi_2(psi_1, pairing);
    const double exact = with_micro_slip(psi_1, kappa);
    largest = std::max(largest, std::fabs(here - exact));
    EXPECT_LT(std::fabs(here), psi_1);
  }
  EXPECT_LT(largest, 0.45);
  EXPECT_GT(largest, 0.1) << "closer than one spring can be: correct doc/validation.md";
}

}  // namespace
}  // namespace wheel_twin::dem::test
