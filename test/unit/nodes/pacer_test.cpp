#include "nodes/pacer.h"

#include <gtest/gtest.h>

#include <thread>

namespace wheel_twin::nodes {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

TEST(Pacer, NeverComesBackBeforeTheWallClockIsThere) {
  Pacer pacer(20.0);
  const auto begin = Clock::now();
  pacer.start();
  for (int i = 1; i <= 10; ++i) {
    ASSERT_TRUE(pacer.wait_until(0.1 * i));
    EXPECT_GE(seconds_since(begin), 0.1 * i / 20.0);
  }
  EXPECT_GT(pacer.reached(), 0.0);
  EXPECT_LE(pacer.reached(), 20.0 * 1.001);
}

TEST(Pacer, FactorZeroDoesNotWait) {
  Pacer pacer(0.0);
  pacer.start();
  EXPECT_TRUE(pacer.wait_until(1e9));  // would last 30 years
  EXPECT_EQ(pacer.lag(), 0.0);
}

TEST(Pacer, SaysHowLateItIs) {
  Pacer pacer(1e6);
  pacer.start();
  const auto begin = Clock::now();
  while (seconds_since(begin) < 0.01) {
  }
  EXPECT_TRUE(pacer.wait_until(1e-3));  // was due after a nanosecond
  EXPECT_GE(pacer.lag(), 0.009);
}

TEST(Pacer, CanBeInterruptedWhileItWaits) {
  Pacer pacer(1.0);
  pacer.start();
  bool waited = true;
  std::thread waiter([&] { waited = pacer.wait_until(1e6); });
  pacer.interrupt();
  waiter.join();
  EXPECT_FALSE(waited);
  EXPECT_FALSE(pacer.wait_until(0.0));
}

}  // namespace
}  // namespace wheel_twin::nodes
