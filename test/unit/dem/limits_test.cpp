#include "dem/limits.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>

#include "dem/cloud.h"
#include "dem_fixture.h"

namespace wheel_twin::dem {
namespace {

using test::message_of;

GranularSoil balls() {
  GranularSoil soil;
  soil.clumps.name = "balls";
  soil.clumps.shapes = {make_clump("ball", {{{0, 0, 0}, 0.003}})};
  soil.clumps.shares = {1.0};
  soil.clumps.smallest_size = soil.clumps.largest_size = 1.0;
  return soil;
}

TEST(Limits, ABedThatMakesNoSenseIsRefusedBeforeTheWorkBegins) {
  const auto message = [](const std::function<void(BedSettings&)>& change) {
    BedSettings settings;
    change(settings);
    return message_of([&] { make_bed(balls(), settings); });
  };
  for (const double wrong : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(message([&](BedSettings& s) { s.length = wrong; }), testing::HasSubstr("bed: length"));
    EXPECT_THAT(message([&](BedSettings& s) { s.gravity = wrong; }), testing::HasSubstr("bed: gravity"));
    EXPECT_THAT(message([&](BedSettings& s) { s.cloud_density = wrong; }),
                testing::HasSubstr("of the cloud"));
  }
  EXPECT_THAT(message([&](BedSettings& s) { s.fill_friction = std::nan(""); }),
              testing::HasSubstr("friction while filling"));
}

TEST(Limits, ABedThatDoesNotFitIntoMemoryIsRefusedWithNumbers) {
  BedSettings settings;
  settings.length = settings.width = 1e4;
  const std::string message = message_of([&] { make_bed(balls(), settings); });
  EXPECT_THAT(message, testing::HasSubstr("bed of 10000 x 10000 x 0.1 m"));
  EXPECT_THAT(message, testing::HasSubstr("GB of memory"));
  Random random(1);
  EXPECT_THAT(message_of([&] { random_cloud(balls().clumps, CloudRegion{}, 100'000'000'000U, random, 0); }),
              testing::HasSubstr("GB of memory"));
  EXPECT_EQ(message_of([] { check_bed(balls(), BedSettings{}); }), "accepted");
}

}  // namespace
}  // namespace wheel_twin::dem
