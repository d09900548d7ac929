#include "twin/recording_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/error.h"
#include "base/random.h"
#include "effects/catalogue.h"
#include "steady_run.h"
#include "twin/simulate.h"

namespace wheel_twin::twin {
namespace {

/// The rig itself: its soil is a third stiffer and a little stronger than declared.
TwinConfig true_rig() {
  TwinConfig twin = declared_rig();
  twin.soil.k_phi *= 1.35;
  twin.soil.phi += 0.05;
  twin.soil.K *= 1.2;
  return twin;
}

class Recording : public testing::Test {
 protected:
  Recording() { record(true_rig()); }

  /// Five runs of `rig`, forces to 0.05 N.
  void record(const TwinConfig& rig) {
    grids.clear();
    runs.clear();
    Random random(3);
    for (const double slip : {0.0, 0.15, 0.3, 0.45, 0.6}) {
      constexpr int n = 80;
      RunGrid grid = steady_run(slip, 42.1, n, rig.wheel.radius);
      grid.name = "run_" + std::to_string(grids.size());
      set_slip(grid, rig.wheel.radius);
      grid.measured = simulate(rig, grid);
      for (int i = 0; i < n; ++i) {
        for (int c = 0; c < 3; ++c) grid.measured(c, i) += 0.05 * random.normal();
        grid.measured(3, i) += 2e-5 * random.normal();
        for (int c = 4; c < 6; ++c) grid.measured(c, i) += 0.002 * random.normal();
      }
      grids.push_back(grid);
    }
    for (RunGrid& grid : grids) runs.push_back(&grid);
  }

  /// What is told after `change` was done to every run, and whether the grids are again as before it.
  std::vector<std::string> told_after(const std::function<void(RunGrid&)>& change) {
    const std::vector<RunGrid> before = grids;
    for (RunGrid& grid : grids) change(grid);
    std::vector<std::string> told;
    for (const RecordingError& error : put_right(runs, declared_rig())) told.push_back(error.what);
    as_before = true;
    for (std::size_t r = 0; r < grids.size(); ++r) {
      as_before = as_before && grids[r].measured.isApprox(before[r].measured, 1e-6);
      for (int i = 0; i < grids[r].bins(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        as_before = as_before &&
                    std::abs(grids[r].motion[k].wheel_rate - before[r].motion[k].wheel_rate) < 1e-6 &&
                    std::abs(grids[r].motion[k].wheel_angle - before[r].motion[k].wheel_angle) < 1e-5 &&
                    std::abs(grids[r].slip[i] - before[r].slip[i]) < 1e-6;
      }
    }
    return told;
  }

  std::vector<RunGrid> grids;
  std::vector<RunGrid*> runs;
  bool as_before = false;
};

using Told = std::vector<std::string>;

TEST_F(Recording, NothingIsToldOfAGoodLog) {
  EXPECT_EQ(told_after([](RunGrid&) {}), Told{});
}

TEST_F(Recording, AFlippedAxisIsToldAndPutRight) {
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.row(2) *= -1.0; }),
            Told{"the z axis of the force is flipped"});
  EXPECT_TRUE(as_before);
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.row(0) *= -1.0; }),
            Told{"the x axis of the force is flipped"});
  EXPECT_TRUE(as_before);
}

TEST_F(Recording, ExchangedAxesAreToldAndPutRight) {
  const auto exchange = [](int a, int b) {
    return [a, b](RunGrid& g) { g.measured.row(a).swap(g.measured.row(b)); };
  };
  EXPECT_EQ(told_after(exchange(0, 2)), (Told{"what is logged as the z axis of the force is its x axis",
                                              "what is logged as the x axis of the force is its z axis"}));
  EXPECT_TRUE(as_before);
  EXPECT_EQ(told_after(exchange(0, 1)), (Told{"what is logged as the y axis of the force is its x axis",
                                              "what is logged as the x axis of the force is its y axis"}));
  EXPECT_TRUE(as_before);
}

TEST_F(Recording, UnitsOfTheForceAreToldAndPutRight) {
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.topRows(3) *= 0.001; }),
            Told{"the force is logged in kilonewtons, not newtons"});
  EXPECT_TRUE(as_before);
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.topRows(3) /= 9.80665; }),
            Told{"the force is logged in kilograms-force, not newtons"});
}

TEST_F(Recording, UnitsAndSignOfTheDisplacementAreToldAndPutRight) {
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.row(3) *= 1000.0; }),
            Told{"the hub displacement is logged in millimetres, not metres"});
  EXPECT_TRUE(as_before);
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.row(3) *= -1.0; }),
            Told{"the hub displacement is logged flipped: positive upwards"});
  EXPECT_TRUE(as_before);
}

TEST_F(Recording, AFlippedMotorEffortAndATorqueInNewtonMillimetresAreTold) {
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.row(5) *= -1.0; }),
            Told{"the motor effort is logged flipped"});
  EXPECT_TRUE(as_before);
  EXPECT_EQ(told_after([](RunGrid& g) { g.measured.row(4) *= 1000.0; }),
            Told{"the torque is logged in newton millimetres, not newton metres"});
  EXPECT_TRUE(as_before);
}

TEST_F(Recording, DegreesForRadiansAreToldAndPutRight) {
  EXPECT_EQ(told_after([](RunGrid& g) {
              for (auto& m : g.motion) m.wheel_angle *= 57.29578, m.wheel_rate *= 57.29578;
              set_slip(g, declared_rig().wheel.radius);
            }),
            (Told{"the wheel's rate is logged in degrees, not rad",
                  "the wheel's angle is logged in degrees, not rad"}));
  EXPECT_TRUE(as_before);
}

TEST_F(Recording, NoEffectOfTheCatalogueIsTakenForAnErrorOfRecording) {
  for (const effects::EffectType& type : effects::catalogue())
    for (const double sign : {1.0, -1.0}) {
      TwinConfig rig = true_rig();
      rig.effects.push_back({type.name, {}});
      for (const effects::Parameter& p : type.parameters) {
        const double neutral = std::isnan(p.neutral) ? 0.0 : p.neutral;
        const double value = neutral >= p.upper ? p.scale : neutral + 2.0 * sign * p.scale;
        rig.effects.back().values.push_back(std::clamp(value, p.lower, p.upper));
      }
      record(rig);
      EXPECT_EQ(told_after([](RunGrid&) {}), Told{}) << type.name << " " << sign;
      for (const RunGrid& grid : grids) EXPECT_EQ(contradiction(grid), "") << type.name << " " << sign;
    }
}

TEST_F(Recording, AChannelThatStandsStillIsLeftOut) {
  const Told told = told_after([](RunGrid& g) { g.measured.row(0).setConstant(12.0); });
  EXPECT_EQ(told, Told{"drawbar_pull stands at 12 N (saturated, or not connected)"});
  EXPECT_FALSE(grids.front().has(Channel::drawbar_pull));
}

TEST_F(Recording, WhatASensorCutsOffIsLeftOut) {
  const double cut =
      0.5 * grids[3].measured.row(0).tail(60).mean() + 0.5 * grids[2].measured.row(0).tail(60).mean();
  const Told told = told_after([&](RunGrid& g) {
    for (int i = 0; i < g.bins(); ++i)
      if (g.measured(0, i) > cut) g.measured(0, i) = cut - 1e-4 * (i % 7);
  });
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].find("drawbar_pull is cut off at"), 0U) << told[0];
  EXPECT_FALSE(grids[4].measured.row(0).tail(40).array().isFinite().any());
  EXPECT_TRUE(grids[0].measured.row(0).tail(40).array().isFinite().all());
}

TEST_F(Recording, WhatASensorCutsOffIsLeftOutUnderNoiseOfItsOwn) {
  const double cut =
      0.5 * grids[0].measured.row(0).tail(60).mean() + 0.5 * grids[1].measured.row(0).tail(60).mean();
  Random random(3);
  const Told told = told_after([&](RunGrid& g) {
    for (int i = 0; i < g.bins(); ++i)
      g.measured(0, i) = std::min(g.measured(0, i), cut) + 0.02 * random.normal();
  });
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].find("drawbar_pull is cut off at"), 0U) << told[0];
}

TEST_F(Recording, ALogWithEveryChannelSaturatedIsRefused) {
  EXPECT_THROW(told_after([](RunGrid& g) {
                 for (int c = 0; c < channel_rows; ++c) g.measured.row(c).setConstant(1.5 + c);
               }),
               Error);
}

TEST_F(Recording, DeclarationsThatTheLogContradictsAreTold) {
  RunGrid other = grids[0];
  other.declared.slip = 0.5;
  EXPECT_EQ(contradiction(other), "slip 0.50 is declared, its speeds say 0.00");
  other = grids[0];
  other.declared.load = 300.0;
  EXPECT_NE(contradiction(other).find("a load of 300 N is declared, the sensor says 42"), std::string::npos);
}

}  // namespace
}  // namespace wheel_twin::twin
