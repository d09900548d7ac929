#include "twin/run_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "terramechanics/wheel_on_soil.h"

namespace wheel_twin::twin {
namespace {

TwinConfig model() {
  TwinConfig m;
  m.wheel.stiffness = std::nullopt;
  m.soil.c1 = 0.4;
  return m;
}

// A steady run whose every channel is what the semi-empirical model says, plus a known residual.
struct Synthetic {
  logs::Run run;
  run_log::RunLog log;
};

Synthetic synthetic(double pull_residual, double displacement_residual) {
  const TwinConfig m = model();
  Synthetic s;
  s.run.bag = "run.bag";
  s.run.slip = 0.3;
  s.run.load = 42.1;
  s.run.wheel_speed = 0.3;
  const auto state = terramechanics::predict_steady_state(m.wheel, m.soil, 42.1, {0.3, 0.0});
  s.log.epoch = 1e9;
  for (int i = 0; i <= 2000; ++i) {
    const double t = 0.02 * i;
    s.log.joints.time.push_back(t);
    s.log.joints.carriage_position.push_back(0.7 * m.wheel.radius * 0.3 * t);
    s.log.joints.carriage_velocity.push_back(0.7 * m.wheel.radius * 0.3);
    s.log.joints.wheel_angle.push_back(0.3 * t);
    s.log.joints.wheel_rate.push_back(0.3);
    s.log.ft.time.push_back(t);
    s.log.ft.force.emplace_back(state.drawbar_pull + pull_residual, 0.0, 42.1);
    s.log.ft.torque.emplace_back(0.0, 0.0, 0.0);
    s.log.draw_wire.time.push_back(t);
    s.log.draw_wire.value.push_back(state.hub_displacement + displacement_residual);
  }
  return s;
}

// What the twin itself reads, plus a known residual: the errors are that residual, to rounding.
TEST(RunComparison, FindsAKnownResidualOverTime) {
  Synthetic s = synthetic(0.0, 0.0);
  const RunComparison twin = compare_run(model(), s.run, "run.bag", &s.log);
  ASSERT_EQ(twin.failure, "");
  const SeriesComparison& pull_of_twin = *twin.at(Channel::drawbar_pull)->series;
  const SeriesComparison& displacement_of_twin = *twin.at(Channel::hub_displacement)->series;
  EXPECT_NEAR(pull_of_twin.twin.back(), pull_of_twin.measured.back(), 1e-3) << "steady state by another way";
  EXPECT_NEAR(displacement_of_twin.twin.back(), displacement_of_twin.measured.back(), 1e-6);
  for (std::size_t i = 0; i < s.log.ft.time.size(); ++i) {
    s.log.ft.force[i].x() = pull_of_twin.twin[i] - 1.5;
    s.log.draw_wire.value[i] = displacement_of_twin.twin[i] + (i % 2 == 0 ? 0.004 : 0.006);
  }
  const RunComparison comparison = compare_run(model(), s.run, "run.bag", &s.log);
  const auto& pull = comparison.at(Channel::drawbar_pull);
  ASSERT_TRUE(pull && pull->series);
  EXPECT_FALSE(pull->from_average);
  EXPECT_NEAR(pull->error, 1.5, 1e-9);
  EXPECT_NEAR(pull->mean.twin - pull->mean.measured, 1.5, 1e-9);
  const auto& displacement = comparison.at(Channel::hub_displacement);
  ASSERT_TRUE(displacement);
  // The alternation is faster than the low-pass: 13 samples of 20 ms leave a 13th of its 1 mm.
  EXPECT_NEAR(displacement->error, 0.005, 0.0001);
  EXPECT_FALSE(comparison.at(Channel::motor_effort)) << "the log has no effort";
}

TEST(RunComparison, WindowAveragesAreComparedOverTheirWindow) {
  Synthetic s = synthetic(0.0, 0.0);
  logs::Averages averages;
  averages.window_start = 20.0;
  averages.window_end = 30.0;
  averages.drawbar_pull = logs::Average{s.log.ft.force.front().x() - 2.0, 0.1};
  averages.normal_load = logs::Average{42.1, 0.1};
  s.run.averages = averages;
  s.run.load = 40.0;  // declared; the measured one leads the twin
  s.log.ft = {};
  const RunComparison with_bag = compare_run(model(), s.run, "run.bag", &s.log);
  s.run.bag.reset();
  const RunComparison without = compare_run(model(), s.run, "day #0", nullptr);
  for (const RunComparison* comparison : {&with_bag, &without}) {
    ASSERT_EQ(comparison->failure, "");
    EXPECT_TRUE(comparison->measured_load);
    EXPECT_DOUBLE_EQ(comparison->load, 42.1);
    const auto& pull = comparison->at(Channel::drawbar_pull);
    ASSERT_TRUE(pull);
    EXPECT_TRUE(pull->from_average);
    EXPECT_NEAR(pull->mean.twin - pull->mean.measured, 2.0, 1e-3);
    EXPECT_NEAR(pull->error, 2.0, 1e-3);
    EXPECT_FALSE(comparison->at(Channel::normal_load)) << "it leads the twin, so it is no residual";
  }
  EXPECT_TRUE(with_bag.at(Channel::hub_displacement)) << "measured over time";
  EXPECT_FALSE(without.at(Channel::hub_displacement)) << "not measured";
}

TEST(RunComparison, TellsWhyItHasNoPrediction) {
  Synthetic s = synthetic(0.0, 0.0);
  s.run.steering_angle = 1.57;
  TwinConfig m = model();
  m.rig.steering_limit = 1.5;
  EXPECT_NE(compare_run(m, s.run, "run.bag", &s.log).failure, "");
  s.run.steering_angle = 0.0;
  s.log.joints = {};
  EXPECT_NE(compare_run(m, s.run, "run.bag", &s.log).failure.find("no joint states"), std::string::npos);
}

}  // namespace
}  // namespace wheel_twin::twin
