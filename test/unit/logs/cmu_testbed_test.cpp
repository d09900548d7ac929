// The importer on the sample of real logs that ships with the project.
#include "logs/cmu_testbed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/LU>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/error.h"
#include "logs/bag_reader.h"
#include "logs/cmu_testbed_bag.h"
#include "logs/cmu_testbed_motion.h"
#include "logs/cmu_testbed_plates.h"
#include "logs/experiment.h"

namespace wheel_twin::logs::cmu {
namespace {

namespace fs = std::filesystem;

const std::string sample = std::string(WHEEL_TWIN_SOURCE_DIR) + "/data/cmu_testbed_sample";

class Folder {
 public:
  explicit Folder(const std::string& name)
      : path_(fs::temp_directory_path() / ("cmu_testbed_test_" + name + "_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string string() const { return path_.string(); }

 private:
  fs::path path_;
};

const logs::Run& run_of(const Experiment& experiment, const std::string& bag) {
  for (const logs::Run& run : experiment.runs)
    if (run.bag == bag) return run;
  throw Error("no run " + bag);
}

std::string text_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(CmuImport, SampleBecomesTwoExperiments) {
  const Folder out("sample");
  const ImportSummary summary = import(sample, out.string());
  ASSERT_EQ(summary.experiments.size(), 2U);
  const Experiment smooth = read_experiment(out / "smooth");
  const Experiment grouser = read_experiment(out / "grouser");
  EXPECT_EQ(smooth.runs.size(), 14U);  // lines of runs.csv
  EXPECT_EQ(grouser.runs.size(), 15U);
  EXPECT_EQ(smooth.plate_tests.size(), 4U);
  EXPECT_EQ(grouser.wheel.grousers, 24);
  EXPECT_TRUE(fs::exists(out / "smooth/LICENSE")) << "the licence travels with the data";
  EXPECT_NE(smooth.source.find("MIT"), std::string::npos);

  // runs.csv: smooth,2020-12-08,10_20_0_1: slip 0.50009, 0.8127 N, 25.1806 N, 22.7 mm, Vry 20.0038, lateral
  // 0.5322.
  const logs::Run& run = run_of(smooth, "bags/2020-12-08_10_20_0_1.bag");
  EXPECT_EQ(run.group, "2020-12-08");
  EXPECT_DOUBLE_EQ(run.slip, 0.50009);
  EXPECT_NEAR(run.averages->drawbar_pull->mean, 0.8127, 1e-4) << "turned by the measured 0.005 degrees";
  EXPECT_DOUBLE_EQ(run.averages->normal_load->mean, 25.1806);
  EXPECT_NEAR(run.averages->side_force->mean, -0.5322, 1e-4);
  EXPECT_DOUBLE_EQ(run.averages->hub_displacement->mean, 0.0227);
  // The rig's true speeds are 2.9 % above its readings: 20.0038 mm/s x 1.029 over 62.5 mm.
  EXPECT_NEAR(run.wheel_speed, 20.0038e-3 * 1.0285 / 0.0625, 1e-3);
}

TEST(CmuImport, BagsHoldTheWindowMeansOfTheTable) {
  const Folder out("means");
  import(sample, out.string());
  for (const auto& [wheel, bag] :
       {std::pair<std::string, std::string>{"smooth", "bags/2020-12-08_10_20_0_1.bag"},
        {"grouser", "bags/2020-12-14_10_40_0_1.bag"}}) {
    const Experiment experiment = read_experiment(out / wheel);
    const logs::Run& run = run_of(experiment, bag);
    const run_log::RunLog log = read_run_log(experiment.path_of(bag));
    double n = 0.0, displacement = 0.0, carriage = 0.0, rim = 0.0;
    for (std::size_t i = 0; i < log.joints.time.size(); ++i) {
      const double t = log.joints.time[i] - log.joints.time.front();
      if (t < run.averages->window_start || t > run.averages->window_end) continue;
      n += 1.0;
      displacement += log.draw_wire.value[i];
      carriage += log.joints.carriage_velocity[i];
      rim += 0.0625 * log.joints.wheel_rate[i];
    }
    EXPECT_NEAR(displacement / n, run.averages->hub_displacement->mean, 1e-5);
    const double slip = (rim - carriage) / std::max(rim, carriage);
    EXPECT_NEAR(slip, run.slip, 1e-3) << "slip of the measured speeds";
    // The carriage's velocity is the rate of its position, which the logged speed was not.
    const std::size_t a = log.joints.time.size() / 2, b = log.joints.time.size() * 9 / 10;
    const double rate = (log.joints.carriage_position[b] - log.joints.carriage_position[a]) /
                        (log.joints.time[b] - log.joints.time[a]);
    EXPECT_NEAR(rate, carriage / n, 2e-5) << "0.2 % of 10 mm/s: the position's steps are 0.07 mm";
    EXPECT_LT(log.draw_wire.value.front(), -0.03) << "the run starts above the sand";
  }
}

TEST(CmuImport, SignsByTheKnownWeight) {
  // The sensor's accelerometer shows where down is, whatever the documentation says: hanging still, it reads
  // 1 g upward.
  const FtRecording zero = read_ft(sample + "/zero/zero_12-8-20_0.bag");
  const Eigen::Vector3d up = to_rig_axes(zero.acceleration);
  EXPECT_NEAR(up.z(), 1.0, 0.05);
  EXPECT_NEAR(up.head<2>().norm(), 0.0, 0.05);
  // A rotation, not a mirror: torques turn with forces.
  Eigen::Matrix3d axes;
  for (int i = 0; i < 3; ++i) axes.col(i) = to_rig_axes(Eigen::Vector3d::Unit(i));
  EXPECT_NEAR(axes.determinant(), 1.0, 1e-15);
  EXPECT_NEAR((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-15);
}

TEST(CmuImport, PressingsPushUpAndAreTared) {
  std::vector<std::string> remarks;
  const std::vector<Pressing> pressings = read_pressings(sample, remarks);
  ASSERT_EQ(pressings.size(), 4U);
  for (const Pressing& pressing : pressings) {
    // Nothing touches before the stroke: the tare holds to the drift of a day, about 1 N a kelvin of the
    // sensor.
    EXPECT_LT(std::abs(pressing.weight_before), 2.0) << pressing.name;
    EXPECT_GT(pressing.log.ft.force.back().z(), 100.0) << "soil and floor push up: normal load is positive";
    EXPECT_GT(pressing.log.draw_wire.value.back(), pressing.log.draw_wire.value.front())
        << "depth is positive down";
    EXPECT_EQ(pressing.box, pressing.row.indenter == "rigid_floor" ? "deflection" : "small_box");
  }
}

TEST(CmuImport, LagBetweenForceAndDepthIsFound) {
  // Force is a smooth function of depth; depth is pushed by hand, unevenly. Its stamps are 80 ms early.
  run_log::ScalarSeries force, depth;
  const auto course = [](double t) {
    return 0.003 * t + 0.004 * std::sin(1.7 * t) + 0.001 * std::sin(7.0 * t);
  };
  for (int i = 0; i < 900; ++i) {
    force.time.push_back(0.01 * i);
    force.value.push_back(9e4 * std::pow(0.02 + course(0.01 * i), 1.3));
  }
  for (int i = -50; i < 600; ++i) {
    depth.time.push_back(0.0167 * i - 0.08);
    depth.value.push_back(0.02 + course(0.0167 * i));
  }
  const auto lag = align_lag(force, depth);
  ASSERT_TRUE(lag);
  EXPECT_NEAR(*lag, -0.08, 0.0051);
}

TEST(CmuImport, LocalTimeOfTheRig) {
  // US Eastern: 2020-12-08 is winter, 2021-05-27 summer; the clocks changed on 2021-03-14 and 2021-11-07 at 2
  // h.
  EXPECT_EQ(hours_behind_utc(1607426955.0), 5);
  EXPECT_EQ(hours_behind_utc(1622128520.0), 4);
  EXPECT_EQ(hours_behind_utc(1615687199.0), 5);  // 2021-03-14 01:59:59
  EXPECT_EQ(hours_behind_utc(1615687200.0), 4);
  EXPECT_EQ(hours_behind_utc(1636250399.0), 4);  // 2021-11-07 01:59:59
  EXPECT_EQ(hours_behind_utc(1636250400.0), 5);
}

class DamagedSample : public ::testing::Test {
 protected:
  DamagedSample() : folder_("damaged"), out_("damaged_out") {
    fs::copy(sample, folder_.string(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    for (const auto& entry : fs::recursive_directory_iterator(folder_.string()))
      fs::permissions(entry.path(), fs::perms::owner_all, fs::perm_options::add);
  }
  void rewrite(const std::string& file, const std::string& from, const std::string& to) {
    std::string text = text_of(folder_ / file);
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(folder_ / file) << text;
  }
  std::string error() {
    try {
      summary_ = import(folder_.string(), out_.string());
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
  Folder folder_, out_;
  ImportSummary summary_;
};

TEST_F(DamagedSample, AnotherDirectoryIsRefused) {
  fs::remove(folder_ / "runs.csv");
  EXPECT_THAT(error(), ::testing::HasSubstr("runs.csv is missing"));
}

TEST_F(DamagedSample, ARenamedColumnIsNamed) {
  rewrite("runs.csv", "sinkage_mm", "sinkage_cm");
  EXPECT_THAT(error(), ::testing::HasSubstr("column 'sinkage_mm' is missing"));
}

TEST_F(DamagedSample, ABadNumberIsNamedWithItsLine) {
  rewrite("runs.csv", "0.75004", "0,75004");
  EXPECT_THAT(error(), ::testing::HasSubstr("fields where the header has 31"));
  rewrite("runs.csv", "0,75004", "0.75OO4");
  EXPECT_THAT(error(), ::testing::AllOf(::testing::HasSubstr("runs.csv:"),
                                        ::testing::HasSubstr("slip: a number is expected")));
}

// A wheel turned to the right by 90 degrees, locked and dragged sideways: whatever the soil does, it does it
// against the travel. The sensor, which turns with the wheel, has that on its lateral axis.
TEST_F(DamagedSample, ForcesOfASteeredRunAreTurnedIntoRigAxes) {
  std::string text = text_of(folder_ / "runs.csv");
  const auto header = text.find("wheel,day");
  text = text.substr(0, text.find('\n', header) + 1);
  text +=
      "grouser,2020-12-14,10_0_90_1,10,0,90,1,-1,9.99,0.16,0,0,90,-8.4518,3.0,61.229,4.0,19.6568,0.9,0,0,0,"
      "49.98,0.016,70.5,75.5,31.77,1607948671.7,6553,78.32,83.66\n";
  std::ofstream(folder_ / "runs.csv") << text;
  ASSERT_EQ(error(), "");
  const logs::Run run = read_experiment(out_ / "grouser").runs.front();
  EXPECT_NEAR(run.steering_angle, -1.5707963, 1e-6);
  EXPECT_NEAR(run.averages->drawbar_pull->mean, -61.229, 1e-4) << "all of it against the travel";
  EXPECT_NEAR(run.averages->side_force->mean, 8.4518, 1e-4);
  EXPECT_NEAR(*run.averages->drawbar_pull->std, 4.0, 1e-4);
  EXPECT_NEAR(*run.averages->side_force->std, 3.0, 1e-4);
  EXPECT_THAT(summary_.remarks, ::testing::Contains(::testing::HasSubstr("forces of 1 steered runs")));
}

TEST_F(DamagedSample, MissingKinematicsAndPlatesAreNoError) {
  fs::remove_all(folder_ / "kinematics");
  fs::remove(folder_ / "plates.csv");
  fs::remove_all(folder_ / "zero");
  EXPECT_EQ(error(), "");
  EXPECT_EQ(summary_.experiments[0].bags, 0U);
  EXPECT_THAT(summary_.remarks,
              ::testing::Contains(::testing::HasSubstr("29 of 29 runs have no kinematics")));
  EXPECT_EQ(read_experiment(out_ / "smooth").runs.size(), 14U);
}

TEST_F(DamagedSample, ATornKinematicsFileKeepsItsGoodRows) {
  const std::string file = "kinematics/smooth/2020-12-08/10_20_0_1.txt";
  const std::string text = text_of(folder_ / file);
  std::ofstream(folder_ / file) << text.substr(0, text.size() - 20);
  EXPECT_EQ(error(), "");
  EXPECT_THAT(summary_.remarks, ::testing::Contains(::testing::HasSubstr("1 rows left out")));
}

TEST_F(DamagedSample, TheKinematicsOfAnotherRunAreRefused) {
  fs::copy_file(folder_ / "kinematics/grouser/2020-12-14/10_40_0_1.txt",
                folder_ / "kinematics/smooth/2020-12-08/10_20_0_1.txt", fs::copy_options::overwrite_existing);
  EXPECT_THAT(error(), ::testing::HasSubstr("the file of another run"));
}

}  // namespace
}  // namespace wheel_twin::logs::cmu
