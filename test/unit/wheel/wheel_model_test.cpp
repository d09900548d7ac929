#include "wheel/wheel_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <regex>
#include <string>
#include <utility>

#include "base/error.h"
#include "wheel/calibration.h"
#include "wheel/flexible_wheel.h"

namespace wheel_twin::wheel {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;

WheelModel wheel_file(const std::string& name) {
  return read_wheel_file(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels/" + name + ".yaml");
}

std::string message(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

constexpr double kPerDegree = M_PI / 180.0 * 1000.0;  // N m/rad to N mm/deg

// The paper, Sections 6.2 and 8, prints 170.38 and 85.63 N mm/deg.
TEST(Calibration, PrintedProcedureGivesThePrintedNumbers) {
  const double amalia = wheel_file("amalia").rim.flexural_rigidity();
  EXPECT_NEAR(printed_stiffness(64, 0.09, amalia, small_load(0.09, amalia)) * kPerDegree, 170.38,
              0.01 * 170.38);
  const double t0_r0 = wheel_file("t0_r0").rim.flexural_rigidity();
  EXPECT_NEAR(printed_stiffness(64, 0.13, t0_r0, small_load(0.13, t0_r0)) * kPerDegree, 85.63, 0.01 * 85.63);
}

TEST(Calibration, BendingSegmentOfThePapersRim) {
  const WheelModel model = wheel_file("amalia");
  const double L = 2.0 * M_PI * 0.09 / 64;
  EXPECT_NEAR(bending_stiffness(model.rim, Bending::beam, L) * kPerDegree, 147.5, 0.05);  // NOTES: E I / L
  EXPECT_NEAR(
      bending_stiffness(model.rim, Bending::plate, L) / bending_stiffness(model.rim, Bending::beam, L),
      1.0 / 0.91, 1e-12);
}

TEST(Calibration, RefusesALoadThatFlattensTheEllipse) {
  EXPECT_THAT(message([] { printed_stiffness(64, 0.09, 0.0747, 100.0); }), HasSubstr("at most"));
  EXPECT_THAT(message([] { printed_stiffness(62, 0.09, 0.0747, 1.0); }), HasSubstr("multiple of 4"));
}

TEST(WheelModel, ReadsThePapersWheels) {
  const WheelModel amalia = wheel_file("amalia");
  EXPECT_EQ(amalia.segments, 64);
  EXPECT_EQ(amalia.springs.positions * amalia.springs.sets, 32);
  EXPECT_EQ(2.0 * amalia.springs.radial_stiffness, 4980.0);  // a pair, Section 6.2
  const WheelModel t0_r0 = wheel_file("t0_r0");
  EXPECT_EQ(FlexibleWheel(t0_r0).body_count(), 64 + 384);
  EXPECT_NEAR(t0_r0.beams.joint_stiffness * kPerDegree, 47.61, 0.01);
}

TEST(WheelModel, EveryShippedWheelLoadsAndTakesAStep) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels")) {
    FlexibleWheel wheel(read_wheel_file(entry.path().string()));
    wheel.step(1e-5, wheel.hub());
    EXPECT_EQ(wheel.steps(), 1) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 4);
}

TEST(WheelModel, WithoutMultibodySectionIsRigid) {
  const WheelModel model = read_wheel_model(
      yaml::parse_text("name: r\nradius: 0.1\nwidth: 0.05\ngrousers: 24\ngrouser_height: 0.005\n", "r"));
  EXPECT_EQ(model.suspension, Suspension::rigid);
  EXPECT_EQ(FlexibleWheel(model).shape(0).boxes.size(), 2u);
}

TEST(WheelModel, RefusesWithTheLimit) {
  WheelModel model = wheel_file("amalia");
  const auto with = [&](const std::function<void(WheelModel&)>& change) {
    WheelModel changed = model;
    change(changed);
    return message([&] { FlexibleWheel wheel(changed); });
  };
  EXPECT_THAT(with([](WheelModel& m) { m.segments = 63; }), HasSubstr("even number from 24 to 256"));
  EXPECT_THAT(with([](WheelModel& m) { m.segments = 22; }), HasSubstr("even number from 24 to 256"));
  EXPECT_THAT(with([](WheelModel& m) { m.rim.thickness = 0.0; }), HasSubstr("above 0"));
  EXPECT_THAT(with([](WheelModel& m) { m.springs.radial_stiffness = -1.0; }), HasSubstr("at least 0"));
  EXPECT_THAT(with([](WheelModel& m) { m.rim_joint_stiffness = std::nan(""); }), HasSubstr("at least 0"));
  EXPECT_THAT(with([](WheelModel& m) { m.hub_radius = 0.1; }), HasSubstr("between 0 and"));
  EXPECT_THAT(with([](WheelModel& m) {
                m.faults.push_back({16, 0, 0.5});
              }),
              HasSubstr("positions end at 15"));
}

// The same from a file: file, line and limit.
TEST(WheelModel, AFileIsRefusedWithTheLimit) {
  std::ifstream file(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels/amalia.yaml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto with = [&](const std::string& key, const std::string& value) {
    return message([&] {
      read_wheel_model(yaml::parse_text(
          std::regex_replace(text, std::regex(key + ": [^ #\n]+"), key + ": " + value), "w.yaml"));
    });
  };
  EXPECT_EQ(with("segments", "64"), "");
  EXPECT_THAT(with("segments", "63"), HasSubstr("63 segments: an even number from 24 to 256 is needed"));
  EXPECT_THAT(with("segments", "22"), HasSubstr("22 segments: an even number from 24 to 256 is needed"));
  EXPECT_THAT(with("segments", "258"), HasSubstr("258 segments: an even number from 24 to 256 is needed"));
  for (const auto& [key, value] : {std::pair{"  thickness", "0.0"},
                                   {"radial_stiffness", "-2490.0"},
                                   {"turning_stiffness", "-0.1"},
                                   {"young_modulus", "0.0"}}) {
    const std::string refusal = with(key, value);
    EXPECT_THAT(refusal, HasSubstr("w.yaml"));
    EXPECT_THAT(refusal, HasSubstr(std::string(key).substr(std::string(key).find_first_not_of(' '))));
    EXPECT_THAT(refusal, ContainsRegex("range|at least|above|between"));
  }
}

TEST(WheelModel, UnknownKeyIsNamed) {
  EXPECT_THAT(message([] {
                read_wheel_model(yaml::parse_text(
                    "radius: 0.1\nwidth: 0.05\nmultibody: {suspension: rigid, sements: 64}\n", "w.yaml"));
              }),
              HasSubstr("sements"));
}

}  // namespace
}  // namespace wheel_twin::wheel
