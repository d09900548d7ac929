#include "bulk/angle_of_repose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/plot.h"
#include "base/progress.h"
#include "base/random.h"
#include "bulk/folder.h"
#include "bulk/line_fit.h"
#include "dem/cloud.h"
#include "dem/settle.h"

namespace wheel_twin::bulk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double pi = 3.14159265358979323846;
constexpr double degrees = 180.0 / pi;
constexpr double cloud_density = 0.2;

// Funnel: a cone of 45 degrees between the opening and a tube. Heights above the floor.
struct Funnel {
  double opening, tube;           // radii
  double mouth, shoulder, cloud;  // heights: opening, start of the tube, top of the cloud

  double radius_at(double z) const { return std::min(tube, opening + (z - mouth)); }
};

Funnel make_funnel(const dem::GranularSoil& soil, const ReposeSettings& s) {
  const double reach = soil.clumps.largest_bounding_radius();
  const double solid = static_cast<double>(s.clumps) * soil.clumps.mean_volume();
  Funnel f{};
  f.opening = s.opening_radius > 0.0 ? s.opening_radius : 8.0 * reach;
  // The heap will be a cone of about 30 degrees; its top stays below the mouth.
  const double heap_radius = std::cbrt(3.0 * solid / 0.5 / (pi * std::tan(30.0 / degrees)));
  f.mouth = heap_radius * std::tan(35.0 / degrees) + 4.0 * reach;
  f.tube = std::max(1.5 * f.opening, 0.55 * heap_radius);
  f.shoulder = f.mouth + (f.tube - f.opening);
  const double cone =
      pi / 3.0 * (f.tube - f.opening) * (f.tube * f.tube + f.tube * f.opening + f.opening * f.opening);
  f.cloud = f.shoulder + std::max(0.0, solid / cloud_density - cone) / (pi * f.tube * f.tube) + 4.0 * reach;
  return f;
}

dem::System make_world(const dem::GranularSoil& soil, const ReposeSettings& s, const Funnel& f, double half) {
  dem::WorldSettings world;
  world.low = {-half - 0.01, -half - 0.01, -0.01};
  world.high = {half + 0.01, half + 0.01, f.cloud + 0.01};
  world.gravity = {0.0, 0.0, -9.81};
  world.step_fraction = soil.step_fraction;
  world.smallest_size = soil.clumps.smallest_size * (1.0 - 1e-6);  // sizes are rounded to single precision
  world.threads = s.threads;
  dem::System system(world, soil.materials(), soil.clumps.shapes);
  const auto add = [&](const char* name, auto shape, const Vector3d& position) {
    dem::Wall wall;
    wall.name = name;
    wall.material = dem::GranularSoil::wall_material;
    wall.shape = std::move(shape);
    wall.pose.position = position;
    return system.add_wall(wall);
  };
  add("floor", dem::HalfSpace{Vector3d::UnitZ()}, Vector3d::Zero());
  add("side", dem::HalfSpace{Vector3d::UnitX()}, {-half, 0, 0});
  add("side", dem::HalfSpace{-Vector3d::UnitX()}, {half, 0, 0});
  add("side", dem::HalfSpace{Vector3d::UnitY()}, {0, -half, 0});
  add("side", dem::HalfSpace{-Vector3d::UnitY()}, {0, half, 0});
  add("funnel",
      dem::Revolved{
          {Vector2d(f.opening, f.mouth), Vector2d(f.tube, f.shoulder), Vector2d(f.tube, f.cloud + 0.01)}},
      Vector3d::Zero());
  return system;
}

}  // namespace

ReposeProfile fit_repose(const dem::HeightMap& map, double x, double y, double ring_width) {
  std::vector<double> sum;
  std::vector<double> count;
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column) {
      const double r = std::hypot(map.x + column * map.spacing - x, map.y + row * map.spacing - y);
      const auto ring = static_cast<std::size_t>(r / ring_width);
      if (ring >= sum.size()) {
        sum.resize(ring + 1, 0.0);
        count.resize(ring + 1, 0.0);
      }
      const double h = map.at(column, row);
      sum[ring] += std::isfinite(h) ? std::max(0.0, h) : 0.0;  // bare floor counts as height 0
      count[ring] += 1.0;
    }
  ReposeProfile profile;
  for (std::size_t i = 0; i < sum.size() && count[i] > 0.0; ++i) {
    profile.radius.push_back((static_cast<double>(i) + 0.5) * ring_width);
    profile.height.push_back(sum[i] / count[i]);
  }
  if (profile.height.empty()) throw Error("angle of repose: there is no heap");
  const double top = *std::max_element(profile.height.begin(), profile.height.end());
  std::vector<double> radii;
  std::vector<double> heights;
  for (std::size_t i = 0; i < profile.height.size(); ++i)
    if (profile.height[i] > 0.2 * top && profile.height[i] < 0.8 * top) {
      radii.push_back(profile.radius[i]);
      heights.push_back(profile.height[i]);
    }
  if (radii.size() < 3) throw Error("angle of repose: the heap is too small for a fit of its flank");
  const LineFit fit = fit_line(radii, heights);
  profile.angle = std::atan(-fit.slope);
  profile.angle_error = fit.slope_error / (1.0 + fit.slope * fit.slope);
  profile.fit_from = radii.front();
  profile.fit_to = radii.back();
  profile.fit_height = fit.intercept;
  return profile;
}

ReposeResult angle_of_repose(const dem::GranularSoil& soil, const ReposeSettings& s) {
  const Funnel f = make_funnel(soil, s);
  const double solid = static_cast<double>(s.clumps) * soil.clumps.mean_volume();
  const double heap_radius = std::cbrt(3.0 * solid / 0.5 / (pi * std::tan(30.0 / degrees)));
  const double half = std::max(1.8 * heap_radius, f.tube + 4.0 * soil.clumps.largest_bounding_radius());
  dem::System system = make_world(soil, s, f, half);

  dem::CloudRegion region;
  region.low = {-f.tube, -f.tube, f.mouth};
  region.high = {f.tube, f.tube, f.cloud};
  region.admits = [&](const Vector3d& center, double radius) {
    // Inside the tube, and off the cone by the sphere's radius.
    const double r = std::hypot(center.x(), center.y());
    return r + radius < f.tube && r + std::sqrt(2.0) * radius < f.radius_at(center.z()) &&
           center.z() - radius > f.mouth;
  };
  Random random(s.seed);
  system.add(random_cloud(soil.clumps, region, s.clumps, random, dem::GranularSoil::grain_material));
  dem::Wall gate;
  gate.name = "gate";
  gate.material = dem::GranularSoil::wall_material;
  gate.shape = dem::Revolved{{Vector2d(0.0, f.mouth), Vector2d(f.opening, f.mouth)}};
  const std::uint32_t gate_number = system.add_wall(gate);

  Progress progress("angle of repose", 1.0);
  dem::SettleSettings fill;
  fill.shortest_time = std::sqrt(2.0 * (f.cloud - f.mouth) / 9.81);
  fill.rest_fraction = 1e-3;
  fill.longest_time = 1.0;
  fill.quenches = 0;
  settle(system, fill,
         [&](double time) { progress.update(0.2 * std::min(1.0, time / (2.0 * fill.shortest_time))); });
  system.remove_wall(gate_number);

  // Beverloo, Leniger and van de Velde (1961): time in which a funnel empties, for the shortest time before
  // rest counts.
  const double grain = 2.0 * std::cbrt(3.0 * soil.clumps.mean_volume() / (4.0 * pi));
  const double flow =
      0.58 * 0.5 * std::sqrt(9.81) * std::pow(2.0 * f.opening - 1.4 * grain, 2.5);  // solid volume a second
  dem::SettleSettings flowing;
  flowing.shortest_time = std::min(0.5 * solid / flow, 0.5 * s.longest_time);
  flowing.longest_time = s.longest_time;
  flowing.rest_fraction = 1e-4;
  flowing.quenches = 0;
  settle(system, flowing,
         [&](double time) { progress.update(0.2 + 0.8 * std::min(1.0, time * flow / (1.5 * solid))); });

  ReposeResult result;
  result.clumps = system.size();
  result.simulated_time = system.time();
  std::vector<dem::SphereState> heap;
  double mass = 0.0;
  double x = 0.0;
  double y = 0.0;
  for (const dem::SphereState& sphere : system.spheres()) {
    if (sphere.center.z() > f.mouth) continue;
    heap.push_back(sphere);
    const double volume = std::pow(sphere.radius, 3);
    mass += volume;
    x += volume * sphere.center.x();
    y += volume * sphere.center.y();
  }
  if (heap.size() < system.sphere_count() / 2)
    throw Error("angle of repose: more than half of the clumps stay in the funnel: its opening is too small");
  const dem::Box floor{{-half, -half, 0.0}, {half, half, f.mouth}};
  result.surface = height_map(heap, floor, 0.5 * soil.clumps.smallest_radius());
  result.profile = fit_repose(result.surface, x / mass, y / mass, grain);
  result.angle = result.profile.angle;
  result.angle_error = result.profile.angle_error;
  result.heap_height = *std::max_element(result.profile.height.begin(), result.profile.height.end());
  return result;
}

void write_repose_report(const std::string& folder, const dem::GranularSoil& soil, const ReposeSettings& s,
                         const ReposeResult& result) {
  make_folder(folder);
  const ReposeProfile& p = result.profile;
  std::string csv = "radius_m,mean_height_m\n";
  PlotSeries rings{"mean surface of the rings", {}, {}, PlotSeries::Style::points};
  for (std::size_t i = 0; i < p.radius.size(); ++i) {
    csv += fmt::format("{:.6g},{:.6g}\n", p.radius[i], p.height[i]);
    rings.x.push_back(1e3 * p.radius[i]);
    rings.y.push_back(1e3 * p.height[i]);
  }
  write_file(folder + "/profile.csv", csv);
  const double slope = std::tan(p.angle);
  Plot plot{fmt::format("Angle of repose, {}", soil.name),
            "distance from the axis (mm)",
            "height (mm)",
            {rings},
            {},
            {},
            true};
  plot.series.push_back(
      {fmt::format("{:.2f} degrees", p.angle * degrees),
       {1e3 * p.fit_from, 1e3 * p.fit_to},
       {1e3 * (p.fit_height - slope * p.fit_from), 1e3 * (p.fit_height - slope * p.fit_to)}});
  write_svg(folder + "/angle_of_repose.svg", {plot});
  const nlohmann::ordered_json json = {
      {"schema", 1},
      {"test", "angle_of_repose"},
      {"soil", soil.name},
      {"clumps", result.clumps},
      {"seed", s.seed},
      {"friction", soil.grain_grain.friction},
      {"angle_of_repose",
       {{"value", p.angle}, {"stderr", p.angle_error}, {"unit", "rad"}, {"degrees", p.angle * degrees}}},
      {"fit", "line through the mean height of rings, between 20 and 80 % of the heap's height"},
      {"heap_height", {{"value", result.heap_height}, {"unit", "m"}}},
      {"simulated_time", {{"value", result.simulated_time}, {"unit", "s"}}}};
  write_file(folder + "/angle_of_repose.json", json.dump(2) + "\n");
}

}  // namespace wheel_twin::bulk
