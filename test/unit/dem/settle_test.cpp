#include "dem/settle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

// Density falls with friction and levels off, as random packings do.
double packing(double friction) {
  return 0.54 + 0.1 * std::exp(-friction / 0.3);
}

TEST(TuneFriction, FindsTheFrictionInFewPackings) {
  for (const double target : {0.55, 0.58, 0.62}) {
    int calls = 0;
    const double friction = tune_friction(target, 0.9, 1e-4, [&](double mu) {
      ++calls;
      return packing(mu);
    });
    EXPECT_NEAR(packing(friction), target, 1e-4);
    EXPECT_LE(calls, 14);
  }
}

TEST(TuneFriction, SaysWhatIsOutOfReach) {
  const auto message = [](double target) {
    try {
      tune_friction(target, 0.9, 1e-3, packing);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message(0.50).find("at friction 0.9 it is already 0.545"), std::string::npos);
  EXPECT_NE(message(0.70).find("0.700 is out of reach"), std::string::npos);
}

}  // namespace
}  // namespace wheel_twin::dem
