#include "dem/state_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "base/error.h"
#include "base/random.h"
#include "dem/bed.h"
#include "dem/cloud.h"

namespace wheel_twin::dem {
namespace {

GranularSoil small_soil() {
  GranularSoil soil;
  soil.clumps.name = "dumbbells";
  soil.clumps.shapes = {make_clump("dumbbell", {{{0, 0, 0}, 0.003}, {{0.004, 0, 0}, 0.003}})};
  soil.clumps.shares = {1.0};
  soil.clumps.smallest_size = 0.9;
  soil.clumps.largest_size = 1.1;
  return soil;
}

System falling(const GranularSoil& soil) {
  BedSettings s;
  s.length = s.width = 0.04;
  s.depth = 0.03;
  System system = bed_world(soil, s, 0.05, 1);
  CloudRegion region;
  region.low = {0.0, -0.02, -0.03};
  region.high = {0.04, 0.02, 0.04};
  region.periodic_x = region.periodic_y = true;
  Random random(3);
  system.add(random_cloud(soil.clumps, region, 120, random, GranularSoil::grain_material));
  Wall plate;
  plate.name = "plate";
  plate.material = GranularSoil::wall_material;
  plate.shape = parallelogram({-0.01, -0.01, 0.0}, {0.02, 0.0, 0.0}, {0.0, 0.02, 0.0});
  plate.pose.position = {0.02, 0.0, 0.045};
  plate.motion.velocity.z() = -0.1;
  system.add_wall(plate);
  return system;
}

std::string hash_of(const System& system) {
  Archive archive;
  store(system.state(), archive);
  return archive.hash();
}

class StateFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("state_file_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(StateFile, ARestartGoesOnWithTheSameBits) {
  const GranularSoil soil = small_soil();
  System straight = falling(soil);
  straight.step(4000);
  const std::string file = (folder_ / "checkpoint.h5").string();
  write_checkpoint(file, straight);
  straight.step(1500);

  System resumed = falling(soil);
  restore_checkpoint(file, resumed);
  ASSERT_GT(resumed.state().contacts.size(), 20U);  // histories are what a restart could lose
  resumed.step(1500);
  EXPECT_EQ(resumed.step_number(), straight.step_number());
  EXPECT_EQ(hash_of(resumed), hash_of(straight));
  resumed.step(1);
  EXPECT_NE(hash_of(resumed), hash_of(straight));
}

TEST_F(StateFile, ACheckpointOfAnotherSystemIsRefused) {
  const GranularSoil soil = small_soil();
  System system = falling(soil);
  const std::string file = (folder_ / "checkpoint.h5").string();
  write_checkpoint(file, system);
  GranularSoil other = soil;
  other.grain.shear_modulus = 2e7;
  System stranger = falling(other);
  EXPECT_THROW(restore_checkpoint(file, stranger), Error);
}

TEST_F(StateFile, TheLastCheckpointOutlivesARunThatFails) {
  const GranularSoil soil = small_soil();
  const std::string file = (folder_ / "checkpoint.h5").string();
  System straight = falling(soil);
  straight.step(3000);
  System failing = falling(soil);
  failing.step(2000);
  write_checkpoint(file, failing);
  failing.set_velocity(7, {0.0, 0.0, 1e6}, {0.0, 0.0, 0.0});
  EXPECT_THROW(failing.step(1000), Error);
  System resumed = falling(soil);
  restore_checkpoint(file, resumed);
  resumed.step(1000);
  EXPECT_EQ(hash_of(resumed), hash_of(straight));
}

TEST_F(StateFile, ABedIsMadeOnceAndFetchedAfter) {
  setenv("WHEEL_TWIN_CACHE", folder_.c_str(), 1);
  GranularSoil soil = small_soil();
  BedSettings s;
  s.length = s.width = 0.04;
  s.depth = 0.03;
  s.fill_friction = 0.3;
  const Bed made = fetch_bed(soil, s);
  const std::string file = (folder_ / "copy.h5").string();
  write_bed(file, made, "test");
  const auto count = [&] {
    return std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator());
  };
  const auto files = count();
  const Bed fetched = fetch_bed(soil, s);
  EXPECT_EQ(count(), files);
  System a = bed_system(soil, made, 0.05, 1);
  System b = bed_system(soil, fetched, 0.05, 1);
  System c = bed_system(soil, read_bed(file), 0.05, 1);
  a.step(50);
  b.step(50);
  c.step(50);
  EXPECT_EQ(hash_of(a), hash_of(b));
  EXPECT_EQ(hash_of(a), hash_of(c));
  s.seed = 2;
  EXPECT_NE(bed_description(soil, s), bed_description(soil, made.settings));
  // The bed is what it says: level at z = 0, at rest, its weight on the floor.
  EXPECT_GT(made.report.packing_density, 0.5);
  EXPECT_LT(made.report.packing_density, 0.72);
  EXPECT_NEAR(made.report.floor_force, made.report.weight, 0.01 * made.report.weight);
  const Box region{{0.0, -0.02, -0.03}, {0.04, 0.02, 0.05}};
  EXPECT_NEAR(mean_height(height_map(a.spheres(), region, 0.001)), 0.0, 0.001);
  SleepSettings sleep;
  sleep.enabled = true;
  System sleeping = bed_system(soil, made, 0.05, 1, sleep);
  sleeping.step(3000);
  EXPECT_GT(sleeping.statistics().sleeping, 9 * sleeping.size() / 10);
  unsetenv("WHEEL_TWIN_CACHE");
}

}  // namespace
}  // namespace wheel_twin::dem
