// Results against the fraction of the Rayleigh step (paper, Eq. 4). Against the skins of the neighbour lists
// they do not change by a bit: System.ListsDoNotChangeResults.
#include <gmock/gmock.h>

#include <array>
#include <map>

#include "dem/measures.h"
#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

/// Rebound of two balls that meet obliquely at 0.2 m/s: velocities (m/s) and surface speed of one.
std::array<double, 3> collision(double fraction) {
  WorldSettings settings = empty_space();
  settings.time_step = 0.0;
  settings.step_fraction = fraction;
  System system(settings, table(0.5, 0.4), {ball()});
  // A gap of whole steps: the first touch falls at the same part of a step whatever the step is.
  const double gap = 0.2 * 40.0 * 0.4 * system.rayleigh_step();
  const double offset = 0.6 * kRadius;
  const double along = std::sqrt(4.0 * kRadius * kRadius - offset * offset);
  system.add({at({0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}), at({along + gap, offset, 0.0}, {-0.1, 0.0, 0.0})});
  system.step(static_cast<int>(std::lround(0.03 / system.time_step())));
  EXPECT_EQ(system.loads()[0].force.norm(), 0.0);
  const Particle p = system.particle(0);
  return {p.velocity.x(), p.velocity.y(), p.angular_velocity.z() * kRadius};
}

TEST(StepSize, ACollisionConverges) {
  const auto exact = collision(0.002);
  std::map<double, double> error;
  for (const double fraction : {0.05, 0.1, 0.2, 0.4}) {
    const auto here = collision(fraction);
    for (int k = 0; k < 3; ++k)
      error[fraction] = std::max(error[fraction], std::fabs(here[k] - exact[k]) / 0.2);
  }
  // First order, as the forces lag by half a step.
  EXPECT_LT(error[0.2], 0.004);
  for (const double fraction : {0.1, 0.2, 0.4})
    EXPECT_NEAR(error[fraction] / error[0.5 * fraction], 2.0, 0.4);
}

struct Packing {
  double height = 0.0;    ///< of the mean centre, m
  double contacts = 0.0;  ///< a clump
};

Packing settle(double fraction, std::uint64_t seed) {
  WorldSettings settings;
  settings.low = {0.0, 0.0, -0.01};
  settings.high = {0.06, 0.06, 0.2};
  settings.periodic_x = settings.periodic_y = true;
  settings.step_fraction = fraction;
  settings.smallest_size = 0.9;
  System system(settings, table(), {four()});
  system.add_wall(floor_wall());
  system.add(cloud(5, 5, 8, 0.012, 1, seed, 0.2));
  const auto steps = [&](double time) { return static_cast<int>(time / system.time_step()); };
  system.step(steps(0.3));
  for (int k = 0; k < 100; ++k) {
    system.stop_all();
    system.step(steps(1e-3));
  }
  Packing packing;
  const auto particles = system.particles();
  for (const auto& p : particles) packing.height += p.position.z() / static_cast<double>(particles.size());
  packing.contacts = coordination(system, {{0.0, 0.0, 0.0}, {0.06, 0.06, 0.2}}).per_clump;
  return packing;
}

TEST(StepSize, ABedDoesNotDependOnIt) {
  // Four seeds a step; means agree within what the scatter allows (Student, 99 %, 6 degrees of
  // freedom: 3.71).
  constexpr int kSeeds = 4;
  std::map<double, std::array<std::array<double, 2>, 2>> mean_variance;
  for (const double fraction : {0.1, 0.2, 0.4}) {
    std::vector<Packing> packings;
    for (int seed = 1; seed <= kSeeds; ++seed) packings.push_back(settle(fraction, seed));
    for (int quantity = 0; quantity < 2; ++quantity) {
      const auto value = [&](const Packing& p) { return quantity == 0 ? p.height : p.contacts; };
      auto& [mean, variance] = mean_variance[fraction][quantity];
      mean = variance = 0.0;
      for (const auto& p : packings) mean += value(p) / kSeeds;
      for (const auto& p : packings) variance += std::pow(value(p) - mean, 2) / (kSeeds - 1);
    }
  }
  for (const double fraction : {0.2, 0.4}) {
    for (int quantity = 0; quantity < 2; ++quantity) {
      const auto [mean, variance] = mean_variance[fraction][quantity];
      const auto [finest, finest_variance] = mean_variance[0.1][quantity];
      EXPECT_NEAR(mean, finest, 3.71 * std::sqrt((variance + finest_variance) / kSeeds))
          << fraction << (quantity == 0 ? ": height" : ": contacts");
    }
  }
}

}  // namespace
}  // namespace wheel_twin::dem::test
