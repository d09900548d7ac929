#include "nodes/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace wheel_twin::nodes {
namespace {

using testing::HasSubstr;
using visualization_msgs::Marker;

const Marker* find(const visualization_msgs::MarkerArray& array, const std::string& name, int id) {
  for (const auto& marker : array.markers)
    if (marker.ns == name && marker.id == id) return &marker;
  return nullptr;
}

TEST(Scene, SurfaceCoversTheBinAndShowsTheRut) {
  Rut rut(RutSettings{});
  rut.roll(0.3, 0.02, 0.0);
  const BinSize bin;
  const Marker soil = soil_surface(rut, bin, 0.07);
  EXPECT_EQ(soil.header.frame_id, "rig");
  ASSERT_EQ(soil.points.size() % 3, 0u);
  ASSERT_EQ(soil.points.size(), soil.colors.size());
  const auto by_y = std::minmax_element(soil.points.begin(), soil.points.end(),
                                        [](const auto& a, const auto& b) { return a.y < b.y; });
  EXPECT_NEAR(by_y.first->y, -0.38, 1e-12);
  EXPECT_NEAR(by_y.second->y, 0.38, 1e-12);
  double deepest = 0.0;
  for (const auto& point : soil.points) {
    if (point.z <= -bin.depth) continue;  // the sides
    deepest = std::min(deepest, point.z);
    if (std::abs(point.y) > 0.035 + 0.02 / std::tan(bin.repose_angle) + 1e-9) {
      EXPECT_EQ(point.z, 0.0);
    }
  }
  EXPECT_NEAR(deepest, -0.02, 1e-4);
}

TEST(Scene, ForceArrowsPointAndGrowAsTheForcesDo) {
  Gauges gauges;
  gauges.hub = {0.2, 0.0, 0.07};
  gauges.measured.force = {12.0, 0.0, 42.0};
  const auto array = labels(gauges);
  const Marker* pull = find(array, "force", 0);
  const Marker* load = find(array, "force", 1);
  ASSERT_TRUE(pull && load);
  const double pull_x = pull->points[1].x - pull->points[0].x;
  const double load_z = load->points[1].z - load->points[0].z;
  EXPECT_GT(pull_x, 0.0);
  EXPECT_GT(load_z, 0.0);
  EXPECT_NEAR(load_z / pull_x, 42.0 / 12.0, 1e-9);
  gauges.measured.force = {-5.0, 0.0, 0.0};
  const auto braking = labels(gauges);
  EXPECT_LT(find(braking, "force", 0)->points[1].x, find(braking, "force", 0)->points[0].x);
  EXPECT_EQ(find(braking, "force", 1)->action, static_cast<int>(Marker::DELETE));
}

TEST(Scene, LabelsSayNumbersWithUnitsAndTheResidual) {
  Gauges gauges;
  gauges.title = "amalia on sand";
  gauges.measured.force = {12.04, 0.0, 42.0};
  gauges.measured.hub_displacement = 0.0153;
  EXPECT_THAT(find(labels(gauges), "text", 12)->text, HasSubstr("drawbar pull 12.0 N\n"));
  EXPECT_THAT(find(labels(gauges), "text", 12)->text, HasSubstr("hub displacement 15.3 mm"));
  gauges.has_twin = true;
  gauges.twin = gauges.measured;
  gauges.twin.force.x() = 13.54;
  EXPECT_THAT(find(labels(gauges), "text", 12)->text, HasSubstr("drawbar pull 12.0, 13.5 N (-1.5)"));
}

TEST(Scene, TraceLeavesOutWhatDoesNotMove) {
  Rut rut(RutSettings{});
  Trace trace;
  EXPECT_EQ(find(trace.markers(rut), "trace", 0)->action, static_cast<int>(Marker::DELETE));
  for (int i = 0; i < 1000; ++i) trace.add({0.0, 0.0, 0.09});
  for (int i = 0; i <= 10; ++i) trace.add({0.01 * i, 0.0, 0.09});
  EXPECT_EQ(find(trace.markers(rut), "trace", 0)->points.size(), 11u);
}

}  // namespace
}  // namespace wheel_twin::nodes
