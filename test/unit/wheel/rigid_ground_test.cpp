#include "wheel/rigid_ground.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <string>

#include "base/error.h"
#include "wheel/rolling_wheel.h"

namespace wheel_twin::wheel {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

WheelModel wheel_file(const std::string& name) {
  return read_wheel_file(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels/" + name + ".yaml");
}

WheelModel rigid_wheel(int segments) {
  WheelModel model;
  model.radius = 0.1;
  model.width = 0.06;
  model.segments = segments;
  model.rim.thickness = 0.001;
  return model;
}

std::string message(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

GroundRock box_rock(const Vector3d& low, const Vector3d& high) {
  GroundRock rock;
  for (int i = 0; i < 8; ++i) {
    rock.vertices.emplace_back((i & 1) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
                               (i & 4) != 0 ? high.z() : low.z());
  }
  for (const auto& f : std::vector<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    rock.triangles.push_back({f[0], f[1], f[2]});
    rock.triangles.push_back({f[0], f[2], f[3]});
  }
  return rock;
}

/// Hub deflection of the AMALIA wheel at 42.1 N.
double deflection_on(const Ground& ground) {
  RollingSettings settings;
  settings.ground = ground;
  settings.ground.contact = {1.0e6, 0.0, 0.0};
  WheelModel model = wheel_file("amalia");
  model.grousers = 0;
  RollingWheel wheel(model, settings);
  wheel.settle(1e-6);
  EXPECT_NEAR(wheel.ground_force().z(), 42.1, 0.05);
  EXPECT_NEAR(wheel.wheel().reaction().force.z(), 42.1, 0.05);
  return wheel.deflection();
}

// A floor is a floor, however it is described: as level floor by corners, as Bullet's box, as the hull of
// eight corners.
TEST(RigidGround, LevelGroundOfAnyKindCarriesAlike) {
  Ground floor;
  const double exact = deflection_on(floor);
  Ground box;
  box.floor.reset();
  box.boxes = {{{0.0, 0.0, -0.05}, {1.0, 1.0, 0.1}, 0.0}};
  EXPECT_NEAR(deflection_on(box) / exact, 1.0, 0.01);  // the deflection on a box holds the box's own give
  Ground rock;
  rock.floor.reset();
  rock.rocks = {box_rock({-0.5, -0.5, -0.1}, {0.5, 0.5, 0.0})};
  EXPECT_NEAR(deflection_on(rock) / exact, 1.0, 0.01);
}

// A rigid wheel against the edge of a step of height h is pushed along the line from the edge to the hub: to
// climb it the hub must be drawn with W sqrt(2 R h - h^2) / (R - h) (moments about the edge).
TEST(RigidGround, StepPushesAlongTheLineFromItsEdgeToTheHub) {
  const WheelModel model = rigid_wheel(256);
  const double R = model.radius + 0.5 * model.rim.thickness, h = 0.02;
  Ground ground;
  ground.boxes = {{{0.5, 0.0, 0.5 * h}, {1.0, 0.2, h}, 0.0}};
  FlexibleWheel wheel(model);
  HubMotion hub;
  // The hub so high and far that the rim just overlaps the edge at x = 0, z = h, and clears the floor.
  const double z = R + 0.002;
  hub.position = {-std::sqrt(R * R - (z - h) * (z - h)) + 2e-5, 0.0, z};
  // The middle of a plate meets the edge.
  const double to_edge = std::atan2(-hub.position.x(), h - z);
  const double pitch = 2.0 * M_PI / model.segments;
  hub.angle = to_edge - pitch * std::floor(to_edge / pitch);
  wheel.place(hub);
  RigidGround contact(wheel, ground);
  const Vector3d force = contact.press(wheel, 1e-5);
  ASSERT_GT(force.z(), 0.1);
  EXPECT_NEAR(-force.x() / force.z(), std::sqrt(R * R - (z - h) * (z - h)) / (z - h), 0.01);
  EXPECT_NEAR(force.y(), 0.0, 1e-9);
  for (const GroundContact& c : contact.contacts()) {
    EXPECT_NEAR(c.point.z(), h, 5e-4);
    EXPECT_NEAR(c.point.x(), 0.0, 5e-4);
  }
}

// Two bodies touch on the line of centres; the depth is what the distance says.
TEST(RigidGround, StoneMeetsTheWheelOnTheLineOfCentres) {
  const WheelModel model = rigid_wheel(256);
  const double R = model.radius + 0.5 * model.rim.thickness, r = 0.03, overlap = 2e-5;
  Ground ground;
  ground.floor.reset();
  ground.spheres = {{{0.0, 0.0, 0.0}, r}};
  ground.contact = {4.0e5, 0.0, 0.0};
  FlexibleWheel wheel(model);
  const double slope =
      16.0 * 2.0 * M_PI / model.segments;  // of the line, from the vertical; a plate's middle
  HubMotion hub;
  hub.position = (R + r - overlap) * Vector3d(-std::sin(slope), 0.0, std::cos(slope));
  wheel.place(hub);
  RigidGround contact(wheel, ground);
  const Vector3d force = contact.press(wheel, 1e-5);
  ASSERT_EQ(contact.contacts().size(), 1u);
  const GroundContact& c = contact.contacts().front();
  // The plate is flat: its middle lies R (1 - cos(pitch / 2)) inside the circle.
  const double flat = model.radius * (1.0 - std::cos(M_PI / model.segments));
  EXPECT_NEAR(c.overlap, overlap - flat, 1e-6);
  EXPECT_NEAR(c.normal.x(), -std::sin(slope), 1e-3);
  EXPECT_NEAR(force.norm(), 2.0e5 * c.overlap, 1e-6 * force.norm());
}

TEST(RigidGround, WheelThatRollsOverAStoneComesDownAgain) {
  RollingSettings settings;
  settings.load = 20.0;
  settings.speed = 0.3;
  settings.ground.spheres = {{{0.10, 0.0, -0.03}, 0.035}};  // 5 mm high
  settings.ground.contact = {5.0e5, 10.0, 0.8};
  WheelModel model = wheel_file("amalia");
  model.grousers = 0;
  RollingWheel rolling(model, settings);
  rolling.settle();
  const double before = rolling.wheel().hub().position.z();
  double highest = before, after = 0.0;
  int samples = 0;
  while (rolling.wheel().hub().position.x() < 0.22) {
    rolling.step();
    const HubMotion hub = rolling.wheel().hub();
    highest = std::max(highest, hub.position.z());
    if (hub.position.x() > 0.19) {
      after += hub.position.z();
      ++samples;
    }
  }
  EXPECT_GT(highest - before, 0.003);  // the rim gives way to the stone
  EXPECT_LT(highest - before, 0.006);
  EXPECT_NEAR(after / samples, before, 2e-4);
}

TEST(RigidGround, TouchesFromAbove) {
  const WheelModel model = rigid_wheel(64);
  FlexibleWheel wheel(model);
  const double corner =
      std::hypot(model.radius * std::cos(M_PI / 64) + 0.0005, model.radius * std::sin(M_PI / 64));
  Ground ground;
  ground.floor = 0.3;
  EXPECT_NEAR(RigidGround::touching_height(wheel, ground), 0.3 + corner * std::cos(M_PI / 64), 2e-4);
  ground.floor.reset();
  ground.boxes = {{{5.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 0.0}};
  EXPECT_THAT(message([&] { RigidGround::touching_height(wheel, ground); }), HasSubstr("no ground below"));
}

TEST(Ground, ReadsTheShippedOnes) {
  const std::string folder = std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/grounds/";
  EXPECT_EQ(read_ground_file(folder + "step.yaml").boxes.size(), 1u);
  EXPECT_EQ(read_ground_file(folder + "stones.yaml").spheres.size(), 3u);
}

TEST(Ground, ReadsARockBesideItsFile) {
  const std::string stem = ::testing::TempDir() + "ground_" + std::to_string(getpid());
  std::ofstream(stem + ".obj") << "# a wedge\nv 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0.1\nf 1/1 2/2 3 -1\n";
  const std::string name = stem.substr(stem.rfind('/') + 1);
  std::ofstream(stem + ".yaml") << "floor: null\nrocks: [{file: " << name << ".obj, at: [2, 0, 0]}]\n";
  const Ground ground = read_ground_file(stem + ".yaml");
  ASSERT_EQ(ground.rocks.size(), 1u);
  EXPECT_EQ(ground.rocks[0].triangles.size(), 2u);
  EXPECT_EQ(ground.rocks[0].vertices[1], Vector3d(3.0, 0.0, 0.0));
  std::ofstream(stem + ".obj") << "v 0 0 0\nf 1 2 3\n";
  EXPECT_THAT(message([&] { read_ground_file(stem + ".yaml"); }),
              HasSubstr("obj:2: '2' is none of 1 vertices"));
}

TEST(Ground, RefusesWhatIsNone) {
  EXPECT_THAT(message([] { read_ground(yaml::parse_text("floor: null\n", "g.yaml")); }),
              HasSubstr("no ground"));
  EXPECT_THAT(
      message([] { read_ground(yaml::parse_text("spheres: [{centre: [0, 0], radius: 1}]\n", "g.yaml")); }),
      HasSubstr("three numbers"));
  EXPECT_THAT(message([] { read_ground(yaml::parse_text("stiffness: -1\n", "g.yaml")); }),
              HasSubstr("stiffness"));
}

}  // namespace
}  // namespace wheel_twin::wheel
