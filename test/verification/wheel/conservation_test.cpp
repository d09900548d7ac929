// A wheel that spins freely in space, hub and all, after a blow: what must stay, stays.
#include <gtest/gtest.h>

#include <cmath>

#include "cases.h"

namespace wheel_twin::wheel {
namespace {

TEST(Conservation, AmaliaKeepsMomentumAndEnergyForTenSeconds) {
  WheelModel model = configured_wheel("amalia", Bending::beam);
  model.damping_ratio = 0.0;
  FlexibleWheel wheel(model);
  const Drift drift = free_spin(wheel, 2e-5, 10.0);
  EXPECT_LT(drift.momentum, 1e-9);
  EXPECT_LT(drift.energy, 1e-4);
  EXPECT_GT(drift.elastic_share, 0.005) << "the blow must leave a vibration to speak of";
}

TEST(Conservation, T0R0KeepsMomentumAndEnergy) {
  WheelModel model = configured_wheel("t0_r0", Bending::beam);
  model.damping_ratio = 0.0;
  FlexibleWheel wheel(model);
  const Drift drift = free_spin(wheel, 2e-5, long_run() ? 10.0 : 0.4);
  EXPECT_LT(drift.momentum, 1e-9);
  EXPECT_LT(drift.energy, 1e-4);
}

// The energy that is lost is the dampers' work; the angular momentum is still there.
TEST(Conservation, EnergyLostIsTheDampersWork) {
  for (const char* name : {"amalia", "t0_r0"}) {
    FlexibleWheel wheel(configured_wheel(name, Bending::beam));
    const double dt = std::min(1e-5, wheel.stable_step());
    strike(wheel, dt);
    const auto energy = [&] { return wheel.energy().kinetic + wheel.energy().elastic; };
    const double L = wheel.angular_momentum(), E = energy(), work = wheel.energy().dissipated;
    for (int i = 0; i < 10000; ++i) wheel.step(dt, {});
    const double lost = E - energy();
    EXPECT_GT(lost, 0.2 * wheel.energy().elastic) << name;
    EXPECT_NEAR((wheel.energy().dissipated - work) / lost, 1.0, 0.005) << name;
    EXPECT_NEAR(wheel.angular_momentum() / L, 1.0, 1e-9) << name;
  }
}

}  // namespace
}  // namespace wheel_twin::wheel
