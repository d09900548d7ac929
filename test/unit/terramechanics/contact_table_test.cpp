#include "terramechanics/contact_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "base/random.h"
#include "terramechanics/wheel_on_soil.h"

namespace wheel_twin::terramechanics {
namespace {

Wheel wheel(bool flexible) {
  Wheel w;
  w.radius = 0.09;
  w.width = 0.07;
  w.grousers = 16;
  w.grouser_height = 0.005;
  if (flexible) w.stiffness = 15000.0;
  return w;
}

class ContactTableTest : public testing::TestWithParam<bool> {};

TEST_P(ContactTableTest, LoadsAreThoseOfTheIntegralsWhateverChanges) {
  Random random(3, 1);
  int covered = 0;
  for (int soil_number = 0; soil_number < 3; ++soil_number) {
    Soil soil;
    soil.n = random.uniform(0.6, 1.5);
    soil.K = random.uniform(0.006, 0.04);
    soil.gamma = random.uniform(0.0, 1.0);
    soil.c1 = random.uniform(0.1, 0.5);
    const Wheel w = wheel(GetParam());
    const auto table = std::make_shared<ContactTable>(w, soil);
    for (int i = 0; i < 25; ++i) {
      Soil changed = soil;
      changed.phi = random.uniform(0.4, 0.8);
      const double modulus = std::exp(random.uniform(-1.0, 1.0));
      changed.k_c *= modulus;
      changed.k_phi *= modulus;
      SoilChange change;
      change.added_cohesion = random.uniform(0.0, 1000.0);
      change.stiffness_factor = random.uniform(0.5, 2.0);
      change.sinkage_factor = random.uniform(0.8, 1.3);
      const Operation operation{random.uniform(-0.9, 0.9), 0.0};
      const double h = random.uniform(0.003, 0.025);
      const ContactState exact = WheelOnSoil(w, changed).at_hub_displacement(h, operation, change);
      const ContactState quick = WheelOnSoil(w, changed, table).at_hub_displacement(h, operation, change);
      const double size = std::abs(exact.normal_load) + 5.0;
      ASSERT_NEAR(quick.normal_load, exact.normal_load, 5e-4 * size);
      ASSERT_NEAR(quick.drawbar_pull, exact.drawbar_pull, 1e-3 * size) << operation.slip;
      ASSERT_NEAR(quick.drive_torque, exact.drive_torque, 1e-3 * size * w.radius);
      ASSERT_NEAR(quick.deflection, exact.deflection, 2e-4 * h);
      const ContactState rest = WheelOnSoil(w, changed).at_rest_at_hub_displacement(h, change);
      const ContactState quick_rest = WheelOnSoil(w, changed, table).at_rest_at_hub_displacement(h, change);
      ASSERT_NEAR(quick_rest.normal_load, rest.normal_load, 2e-4 * (rest.normal_load + 5.0));
      covered += table->covers(exact.sinkage / change.sinkage_factor, exact.deflection, operation.slip);
    }
  }
  EXPECT_GT(covered, 60);
}

INSTANTIATE_TEST_SUITE_P(RigidAndFlexible, ContactTableTest, testing::Bool());

TEST(ContactTable, ThreadsGetTheSameNumbers) {
  const Soil soil;
  const ContactTable shared(wheel(true), soil), alone(wheel(true), soil);
  ContactLaw law;
  law.b = 0.07;
  law.k_eq = 1e6;
  law.tan_phi = 0.7;
  std::vector<double> found[2];
  const auto ask = [&](std::vector<double>& out) {
    for (int i = 0; i < 400; ++i) out.push_back(shared.vertical(0.002 + 3e-5 * i, 0.002, 0.3, law));
  };
  std::thread other(ask, std::ref(found[1]));
  ask(found[0]);
  other.join();
  EXPECT_EQ(found[0], found[1]);
  for (int i = 0; i < 400; ++i)
    EXPECT_EQ(found[0][static_cast<std::size_t>(i)], alone.vertical(0.002 + 3e-5 * i, 0.002, 0.3, law));
}

TEST(ContactTable, FitsOnlyItsOwnShape) {
  const Soil soil;
  const ContactTable table(wheel(true), soil);
  Soil stiffer = soil;
  stiffer.k_phi *= 2.0;
  stiffer.phi += 0.1;
  stiffer.c = 500.0;
  EXPECT_TRUE(table.fits(wheel(true), stiffer));
  Soil other = soil;
  other.K *= 1.01;
  EXPECT_FALSE(table.fits(wheel(true), other));
  EXPECT_FALSE(table.fits(wheel(false), soil));
  EXPECT_FALSE(table.covers(1e-9, 0.002, 0.3));
  EXPECT_FALSE(table.covers(0.01, 0.002, 0.99));
}

}  // namespace
}  // namespace wheel_twin::terramechanics
