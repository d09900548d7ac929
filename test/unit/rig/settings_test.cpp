#include "rig/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "../message_of.h"
#include "rig/profile.h"
#include "rig/sensor_settings.h"

namespace wheel_twin::rig {
namespace {

const std::string config = std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/";

std::string text_of(const std::string& file) {
  std::ifstream stream(config + file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// The shipped file with one piece of text replaced.
std::string with(const std::string& file, const std::string& old_piece, const std::string& new_piece) {
  std::string text = text_of(file);
  const std::size_t at = text.find(old_piece);
  EXPECT_NE(at, std::string::npos) << old_piece;
  if (at != std::string::npos) text.replace(at, old_piece.size(), new_piece);
  return text;
}

template <typename Read>
std::string message_of(const Read& read, const std::string& text) {
  return wheel_twin::message_of([&] { read(yaml::parse_text(text, "test.yaml")); });
}

TEST(RigFiles, ShippedOnesAreRead) {
  const RigSettings rig = read_rig(yaml::parse_file(config + "rigs/polito.yaml"));
  EXPECT_EQ(rig.name, "polito");
  EXPECT_NEAR(rig.steering_limit, 25.0 * 3.14159265358979 / 180.0, 1e-6);
  EXPECT_FALSE(rig.slide.mass.has_value());
  EXPECT_EQ(rig.mount.drive_torque_share, -1.0);
  read_draw_wire(yaml::parse_file(config + "sensors/micro_epsilon_draw_wire.yaml"));
  read_joints(yaml::parse_file(config + "sensors/motor_joints.yaml"));
  read_temperature(yaml::parse_file(config + "sensors/thermometer.yaml"));
}

// ATI's published table of the Mini45: ranges in N and N m, resolutions as counts per N and N m.
TEST(RigFiles, Mini45CalibrationsAreTheMakers) {
  struct Row {
    const char* name;
    double force_xy, force_z, torque, per_newton, per_newton_metre_xy, per_newton_metre_z;
  };
  for (const Row& row : {Row{"145_5", 145, 290, 5, 16, 752, 1504}, Row{"290_10", 290, 580, 10, 8, 376, 752},
                         Row{"580_20", 580, 1160, 20, 4, 188, 376}}) {
    const FtSettings ft = read_ft(yaml::parse_file(config + "sensors/ati_mini45_si_" + row.name + ".yaml"));
    EXPECT_EQ(ft.rate, 1000.0);
    EXPECT_EQ(ft.range[0], row.force_xy);
    EXPECT_EQ(ft.range[1], row.force_xy);
    EXPECT_EQ(ft.range[2], row.force_z);
    for (int i = 3; i < 6; ++i) EXPECT_EQ(ft.range[i], row.torque);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(ft.resolution[i] * row.per_newton, 1.0);
    for (int i = 3; i < 5; ++i) EXPECT_NEAR(ft.resolution[i] * row.per_newton_metre_xy, 1.0, 1e-6);
    EXPECT_NEAR(ft.resolution[5] * row.per_newton_metre_z, 1.0, 1e-6);
  }
}

TEST(RigFiles, MistakesAreNamed) {
  const auto rig = [](const std::string& old_piece, const std::string& new_piece) {
    return message_of(read_rig, with("rigs/polito.yaml", old_piece, new_piece));
  };
  EXPECT_THAT(rig("stroke: 2.0", "stroke: -2.0"), testing::HasSubstr("carriage.stroke"));
  EXPECT_THAT(rig("stroke: 2.0", "strokes: 2.0"), testing::HasSubstr("stroke"));
  EXPECT_THAT(rig("name: polito", "name: polito\nname: polito"), testing::HasSubstr("second time"));
  EXPECT_THAT(rig("drive_torque_share: -1.0", "drive_torque_share: 2.0"),
              testing::HasSubstr("drive_torque_share"));
  EXPECT_THAT(rig("viscous_damping: 60.0", "viscous_damping: much"), testing::HasSubstr("viscous_damping"));
  const auto ft = [](const std::string& old_piece, const std::string& new_piece) {
    return message_of(read_ft, with("sensors/ati_mini45_si_145_5.yaml", old_piece, new_piece));
  };
  EXPECT_THAT(ft("rate: 1000.0", "rate: 0.0"), testing::HasSubstr("rate"));
  EXPECT_THAT(ft("force: [145.0, 145.0, 290.0]", "force: [145.0, 145.0]"),
              testing::HasSubstr("three numbers"));
  EXPECT_THAT(message_of(read_draw_wire, with("sensors/micro_epsilon_draw_wire.yaml", "wire_at_zero: 0.2",
                                              "wire_at_zero: 0.6")),
              testing::HasSubstr("beyond the range"));
  EXPECT_THAT(message_of(read_profile, "{ramp: 0.1, speed: 3}"), testing::HasSubstr("speed"));
}

}  // namespace
}  // namespace wheel_twin::rig
