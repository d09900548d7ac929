#include <gtest/gtest.h>

#include <cmath>

#include "rig/draw_wire.h"
#include "rig/draw_wire_pull.h"
#include "rig/ft_sensor.h"
#include "rig/instruments.h"
#include "rig/joint_sensor.h"

namespace wheel_twin::rig {
namespace {

WrenchReading wrench(double fx, double fz = 0.0) {
  WrenchReading reading;
  reading.force = {fx, 0.0, fz};
  return reading;
}

struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;
  double correlation = 0.0;  // of neighbours
};

template <typename Get>
Statistics statistics(std::size_t count, const Get& get) {
  Statistics result;
  for (std::size_t i = 0; i < count; ++i) result.mean += get(i) / static_cast<double>(count);
  double square = 0.0, product = 0.0;
  for (std::size_t i = 0; i < count; ++i) square += std::pow(get(i) - result.mean, 2);
  for (std::size_t i = 1; i < count; ++i) product += (get(i) - result.mean) * (get(i - 1) - result.mean);
  result.deviation = std::sqrt(square / static_cast<double>(count));
  result.correlation = square > 0.0 ? product / square : 0.0;
  return result;
}

TEST(FtSensor, NoiseIsWhiteAndOfTheStatedSize) {
  FtSettings settings;
  settings.noise << 0.02, 0.02, 0.05, 4e-4, 4e-4, 2e-4;
  FtSensor sensor(settings, 7);
  run_log::WrenchSeries series;
  const int count = 20000;
  for (int i = 0; i < count; ++i) sensor.observe(1e-3 * i, wrench(3.0, 42.1), series);
  ASSERT_EQ(series.time.size(), static_cast<std::size_t>(count));
  // Standard errors: of the mean sigma/sqrt(n), of the deviation sigma/sqrt(2 n), of the correlation
  // 1/sqrt(n); four each.
  const double n = count;
  const double means[3] = {3.0, 0.0, 42.1};
  for (int axis = 0; axis < 6; ++axis) {
    const Statistics found = statistics(series.time.size(), [&](std::size_t i) {
      return axis < 3 ? series.force[i][axis] : series.torque[i][axis - 3];
    });
    const double sigma = settings.noise[axis];
    EXPECT_NEAR(found.mean, axis < 3 ? means[axis] : 0.0, 4.0 * sigma / std::sqrt(n)) << axis;
    EXPECT_NEAR(found.deviation, sigma, 4.0 * sigma / std::sqrt(2.0 * n)) << axis;
    EXPECT_NEAR(found.correlation, 0.0, 4.0 / std::sqrt(n)) << axis;
  }
  double product = 0.0;  // axes are independent
  for (std::size_t i = 0; i < series.time.size(); ++i)
    product += (series.force[i].x() - 3.0) * (series.force[i].z() - 42.1) / (0.02 * 0.05) / n;
  EXPECT_NEAR(product, 0.0, 4.0 / std::sqrt(n));
}

TEST(FtSensor, ReadsMultiplesOfItsResolution) {
  FtSettings settings;
  settings.resolution << 1.0 / 16, 1.0 / 16, 1.0 / 16, 1.0 / 752, 1.0 / 752, 1.0 / 1504;
  settings.noise.setConstant(0.05);
  FtSensor sensor(settings, 1);
  run_log::WrenchSeries series;
  for (int i = 0; i < 1000; ++i) sensor.observe(1e-3 * i, wrench(0.02 * i, 42.1), series);
  for (std::size_t i = 0; i < series.time.size(); ++i) {
    const double counts = series.force[i].x() * 16.0;
    EXPECT_EQ(counts, std::round(counts));
    const double torque_counts = series.torque[i].z() * 1504.0;
    EXPECT_NEAR(torque_counts, std::round(torque_counts), 1e-9);
    EXPECT_FALSE(std::signbit(series.force[i].y()) && series.force[i].y() == 0.0) << "minus zero";
  }
}

TEST(FtSensor, SaturatesAtTheRangeThatTheToolLeaves) {
  FtSettings settings;
  settings.range << 145.0, 145.0, 290.0, 5.0, 5.0, 5.0;
  settings.tool_weight = 24.5;
  FtSensor sensor(settings, 1);
  run_log::WrenchSeries series;
  sensor.observe(0.0, wrench(500.0, 500.0), series);
  sensor.observe(0.001, wrench(-500.0, -500.0), series);
  EXPECT_EQ(series.force[0].x(), 145.0);
  EXPECT_EQ(series.force[0].z(), 290.0 + 24.5);  // the hanging tool pulls the untared signal down
  EXPECT_EQ(series.force[1].x(), -145.0);
  EXPECT_EQ(series.force[1].z(), -290.0 + 24.5);
}

TEST(FtSensor, LowPassAnswersARampLikeTheClosedForm) {
  FtSettings settings;
  settings.low_pass = 10.0;
  const double lag = 1.0 / (2.0 * M_PI * 10.0);
  FtSensor sensor(settings, 1);
  run_log::WrenchSeries series;
  for (int i = 0; i <= 200; ++i) sensor.observe(1e-3 * i, wrench(1e-3 * i * 50.0), series);
  for (const std::size_t i : {10u, 50u, 200u}) {
    const double t = series.time[i];
    EXPECT_NEAR(series.force[i].x(), 50.0 * (t - lag * (1.0 - std::exp(-t / lag))), 1e-9);
  }
}

TEST(FtSensor, LowPassHalvesThePowerAtItsCorner) {
  FtSettings settings;
  settings.low_pass = 10.0;
  FtSensor sensor(settings, 1);
  run_log::WrenchSeries series;
  double square = 0.0;
  for (int i = 0; i < 4000; ++i) {
    sensor.observe(2.5e-4 * i, wrench(std::sin(2.0 * M_PI * 10.0 * 2.5e-4 * i)), series);
  }
  std::size_t count = 0;
  for (std::size_t i = series.time.size() / 2; i < series.time.size(); ++i, ++count)
    square += std::pow(series.force[i].x(), 2);
  EXPECT_NEAR(square / static_cast<double>(count), 0.25, 0.001);
}

TEST(FtSensor, BiasAndDriftAdd) {
  FtSettings settings;
  settings.bias[0] = 0.5;
  settings.drift[0] = 0.01;
  FtSensor sensor(settings, 1);
  run_log::WrenchSeries series;
  for (int i = 0; i <= 10; ++i) sensor.observe(i, wrench(1.0), series);
  EXPECT_NEAR(series.force[10000].x(), 1.0 + 0.5 + 0.01 * 10.0, 1e-12);
}

TEST(Sensors, SampleAtTheirOwnRateBetweenSteps) {
  FtSettings settings;
  settings.rate = 300.0;  // neither multiple nor divisor of the steps
  FtSensor sensor(settings, 1);
  run_log::WrenchSeries series;
  for (int i = 0; i <= 1000; ++i) sensor.observe(1e-3 * i, wrench(2.0e-3 * i), series);
  ASSERT_EQ(series.time.size(), 301u);
  for (std::size_t i = 0; i < series.time.size(); ++i) {
    EXPECT_NEAR(series.time[i], static_cast<double>(i) / 300.0, 1e-12);
    EXPECT_NEAR(series.force[i].x(), 2.0 * series.time[i], 1e-9);  // a linear signal is met exactly
  }
}

TEST(DrawWire, HasResolutionRangeAndDelay) {
  DrawWireSettings settings;
  settings.rate = 100.0;
  settings.range = 0.5;
  settings.wire_at_zero = 0.45;
  settings.resolution = 5e-5;
  DrawWire sensor(settings, 1);
  run_log::ScalarSeries series;
  for (int i = 0; i <= 10; ++i) sensor.observe(0.01 * i, 0.01 * i, 0.125, series);
  EXPECT_DOUBLE_EQ(series.time[4], 0.04 + 0.125);
  for (const double value : series.value) EXPECT_NEAR(value / 5e-5, std::round(value / 5e-5), 1e-6);
  EXPECT_NEAR(series.value[3], 0.03, 2.5e-5);
  EXPECT_NEAR(series.value[10], 0.05, 1e-12);  // 0.5 m of wire are out at 0.05 m
}

TEST(DrawWire, KeepsItsLinearityAndItsZero) {
  DrawWireSettings settings;
  settings.resolution = 0.0;
  settings.linearity = 1e-3;
  settings.range = 0.5;
  settings.wire_at_zero = 0.2;
  double largest = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    DrawWire sensor(settings, seed);
    run_log::ScalarSeries series;
    for (int i = 0; i <= 300; ++i) sensor.observe(1e-3 * i, 1e-3 * i, 0.0, series);
    EXPECT_EQ(series.value[0], 0.0);
    for (std::size_t i = 0; i < series.value.size(); ++i)
      largest = std::max(largest, std::abs(series.value[i] - 1e-3 * static_cast<double>(i)));
  }
  EXPECT_LE(largest, 2.0 * 1e-3 * 0.5);  // two errors of at most 0.1 % of 0.5 m
  EXPECT_GT(largest, 1e-3 * 0.5);
}

TEST(DrawWirePull, LiftsTheSlideUnlessTrimmedAndRubs) {
  DrawWireSettings settings;
  settings.tension = 5.0;
  settings.tension_hysteresis = 0.4;
  settings.tension_trimmed = false;
  EXPECT_EQ(DrawWirePull(settings).added_dead_weight({}), -5.0);
  EXPECT_EQ(DrawWirePull(settings).coulomb_friction({}), 0.2);
  settings.tension_trimmed = true;
  EXPECT_EQ(DrawWirePull(settings).added_dead_weight({}), 0.0);
}

RigStep step_at(double time) {
  RigStep step;
  step.state.time = time;
  step.readings.wrench = wrench(1.0, 40.0);
  step.readings.displacement = 0.01;
  step.readings.joints.wheel_effort = 2.0;
  return step;
}

SensorSettings noisy() {
  SensorSettings settings;
  settings.ft.noise.setConstant(0.1);
  settings.draw_wire.noise = 1e-4;
  settings.draw_wire.resolution = 0.0;
  settings.joints.effort_noise = 0.1;
  settings.temperature.noise = 0.1;
  return settings;
}

run_log::RunLog logged(const SensorSettings& settings, std::uint64_t seed) {
  Instruments instruments(settings, seed, 1.7e9);
  for (int i = 0; i <= 2000; ++i) instruments.observe(step_at(1e-3 * i), 0.0);
  return instruments.take();
}

TEST(Instruments, RatesAreTheirOwn) {
  const run_log::RunLog log = logged(SensorSettings(), 1);
  EXPECT_EQ(log.epoch, 1.7e9);
  EXPECT_EQ(log.ft.time.size(), 2001u);
  EXPECT_EQ(log.draw_wire.time.size(), 2001u);
  EXPECT_EQ(log.joints.time.size(), 201u);
  EXPECT_EQ(log.temperature.time.size(), 3u);
}

TEST(Instruments, SameSeedSameBitsAndOneStreamASensor) {
  const run_log::RunLog a = logged(noisy(), 5);
  const run_log::RunLog b = logged(noisy(), 5);
  EXPECT_EQ(a.ft.force, b.ft.force);
  EXPECT_EQ(a.draw_wire.value, b.draw_wire.value);
  EXPECT_EQ(a.joints.wheel_effort, b.joints.wheel_effort);
  EXPECT_NE(a.ft.force, logged(noisy(), 6).ft.force);
  SensorSettings other = noisy();
  other.ft.rate = 500.0;  // another rate of one sensor leaves the others' noise alone
  EXPECT_EQ(a.draw_wire.value, logged(other, 5).draw_wire.value);
  EXPECT_EQ(a.joints.wheel_effort, logged(other, 5).joints.wheel_effort);
}

TEST(Instruments, TakeHandsOverPiecewise) {
  Instruments instruments(SensorSettings(), 1, 1.7e9);
  for (int i = 0; i <= 10; ++i) instruments.observe(step_at(1e-3 * i), 0.0);
  EXPECT_EQ(instruments.take().ft.time.size(), 11u);
  instruments.observe(step_at(0.011), 0.0);
  const run_log::RunLog rest = instruments.take();
  ASSERT_EQ(rest.ft.time.size(), 1u);
  EXPECT_NEAR(rest.ft.time[0], 0.011, 1e-12);
  EXPECT_EQ(rest.epoch, 1.7e9);
}

}  // namespace
}  // namespace wheel_twin::rig
