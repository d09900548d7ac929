#include "dem/thread_team.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace wheel_twin::dem {
namespace {

TEST(ThreadTeam, EveryPartRunsOnceInEveryRound) {
  for (const std::size_t size : {1U, 2U, 3U, 7U}) {
    ThreadTeam team(size);
    std::vector<int> count(size, 0);
    for (int round = 1; round <= 2000; ++round) {
      team.run([&](std::size_t part) { ++count[part]; });
      for (const int each : count) ASSERT_EQ(each, round);
    }
  }
}

TEST(ThreadTeam, TheFirstPartsExceptionComesBackAndTheTeamGoesOn) {
  ThreadTeam team(3);
  for (int round = 0; round < 100; ++round) {
    try {
      team.run([](std::size_t part) {
        if (part > 0) throw std::runtime_error(std::to_string(part));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "1");
    }
    std::atomic<std::size_t> sum{0};
    team.run([&](std::size_t part) { sum += part; });
    EXPECT_EQ(sum, 3U);
  }
}

}  // namespace
}  // namespace wheel_twin::dem
