#include "nodes/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "nodes/marker_parts.h"

namespace wheel_twin::nodes {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double newtons_to_metres = 0.005;  // length of a force arrow

/// A fixed value of -1 to 1 for a cell.
double speckle(std::int64_t column, std::int64_t row) {
  std::uint64_t h = static_cast<std::uint64_t>(column) * 0x9e3779b97f4a7c15ULL +
                    static_cast<std::uint64_t>(row) * 0xc2b2ae3d27d4eb4fULL + 0x165667b19e3779f9ULL;
  h = (h ^ (h >> 29)) * 0xbf58476d1ce4e5b9ULL;
  return static_cast<double>((h ^ (h >> 32)) & 0xffff) / 32767.5 - 1.0;
}

/// Smooth mottling of -1 to 1, so that sand does not look like plastic: speckles 25 mm apart, blended.
double mottle(double x, double y) {
  constexpr double cell = 0.025;
  const double column = std::floor(x / cell), row = std::floor(y / cell);
  const double u = x / cell - column, v = y / cell - row;
  const auto i = static_cast<std::int64_t>(column), j = static_cast<std::int64_t>(row);
  return (1 - u) * ((1 - v) * speckle(i, j) + v * speckle(i, j + 1)) +
         u * ((1 - v) * speckle(i + 1, j) + v * speckle(i + 1, j + 1));
}

/// Sand, darker where it has been pressed down.
std_msgs::ColorRGBA sand(double x, double y, double height) {
  const double depth = std::clamp(-height / 0.015, 0.0, 1.0);
  const double grain = 1.0 + 0.05 * mottle(x, y);
  return colour((0.86 - 0.36 * depth) * grain, (0.72 - 0.37 * depth) * grain, (0.50 - 0.31 * depth) * grain);
}

struct Vertex {
  geometry_msgs::Point point;
  std_msgs::ColorRGBA colour;
};

void triangle(Marker& m, const Vertex& a, const Vertex& b, const Vertex& c) {
  for (const Vertex* v : {&a, &b, &c}) {
    m.points.push_back(v->point);
    m.colors.push_back(v->colour);
  }
}

void quad(Marker& m, const Vertex& a, const Vertex& b, const Vertex& c, const Vertex& d) {
  triangle(m, a, b, c);
  triangle(m, a, c, d);
}

/// Across the bin at one column: from the right wall over the rut to the left wall.
constexpr std::size_t beside = 13;  // rows between the rut and a wall
constexpr std::size_t within = 5;   // rows on the rut's floor
constexpr std::size_t rows = 2 * beside + within;
std::array<Vertex, rows> cross_section(const Rut& rut, std::size_t column, const BinSize& bin,
                                       double wheel_width) {
  const double floor = rut.height(column);
  const double half = 0.5 * wheel_width;
  const double brim = half - floor / std::tan(bin.repose_angle);
  const double wall = 0.5 * bin.width;
  const double x = rut.x(column);
  std::array<Vertex, rows> section;
  for (std::size_t i = 0; i < beside; ++i) {
    const double y = brim + (wall - brim) * static_cast<double>(i) / static_cast<double>(beside - 1);
    section[beside - 1 - i] = {point(x, -y, 0.0), sand(x, -y, 0.0)};
    section[beside + within + i] = {point(x, y, 0.0), sand(x, y, 0.0)};
  }
  for (std::size_t i = 0; i < within; ++i) {
    const double y = -half + wheel_width * static_cast<double>(i) / static_cast<double>(within - 1);
    section[beside + i] = {point(x, y, floor), sand(x, y, floor)};
  }
  return section;
}

Marker text(int id, const std::string& words, const geometry_msgs::Point& at, double height,
            const std_msgs::ColorRGBA& tint) {
  Marker m = marker("text", id, Marker::TEXT_VIEW_FACING);
  m.text = words;
  m.pose.position = at;
  m.scale.z = height;
  m.color = tint;
  return m;
}

Marker arrow(int id, const Eigen::Vector3d& from, const Eigen::Vector3d& to, const std_msgs::ColorRGBA& tint,
             double thickness) {
  Marker m = marker("force", id, Marker::ARROW);
  m.points = {point(from.x(), from.y(), from.z()), point(to.x(), to.y(), to.z())};
  m.scale.x = thickness;
  m.scale.y = 2.4 * thickness;
  m.scale.z = std::min(0.035, 0.6 * (to - from).norm());
  m.color = tint;
  if ((to - from).norm() < 1e-4) m.action = Marker::DELETE;
  return m;
}

/// "drawbar pull 12.1 N", or measured, twin and (residual).
std::string line(const char* name, double measured, double twin, bool has_twin, const char* unit) {
  if (!has_twin) return fmt::format("{} {:.1f} {}", name, measured, unit);
  return fmt::format("{} {:.1f}, {:.1f} {} ({:+.1f})", name, measured, twin, unit, measured - twin);
}

}  // namespace

Marker soil_surface(const Rut& rut, const BinSize& bin, double wheel_width) {
  Marker m = marker("soil", 0, Marker::TRIANGLE_LIST);
  m.points.reserve(rut.size() * rows * 6);
  m.colors.reserve(rut.size() * rows * 6);
  const double wall = 0.5 * bin.width;
  auto last = cross_section(rut, 0, bin, wheel_width);
  for (std::size_t column = 1; column < rut.size(); ++column) {
    const auto next = cross_section(rut, column, bin, wheel_width);
    for (std::size_t row = 0; row + 1 < rows; ++row)
      quad(m, last[row], next[row], next[row + 1], last[row + 1]);
    const auto below = [&](std::size_t at) {
      return Vertex{point(rut.x(at), -wall, -bin.depth), sand(rut.x(at), -bin.depth, -0.006)};
    };
    quad(m, below(column - 1), below(column), next[0], last[0]);
    last = next;
  }
  return m;
}

void Trace::add(const Eigen::Vector3d& hub) {
  if (points_.empty() || (hub - points_.back()).norm() >= 0.001) points_.push_back(hub);
}

MarkerArray Trace::markers(const Rut& rut) const {
  Marker path = marker("trace", 0, Marker::LINE_STRIP);
  path.scale.x = 0.004;
  path.color = colour(0.75, 0.10, 0.45);
  for (const auto& p : points_) path.points.push_back(point(p.x(), p.y(), p.z()));
  if (path.points.size() < 2) path.action = Marker::DELETE;

  Marker floor = marker("rut", 1, Marker::LINE_STRIP);
  floor.scale.x = 0.002;
  floor.color = colour(0.30, 0.18, 0.08);
  for (std::size_t i = 0; i < rut.size(); ++i)
    if (rut.height(i) < 0.0) floor.points.push_back(point(rut.x(i), 0.0, rut.height(i) + 0.001));
  if (floor.points.size() < 2) floor.action = Marker::DELETE;
  MarkerArray array;
  array.markers = {path, floor};
  return array;
}

MarkerArray labels(const Gauges& g) {
  const auto ink = colour(0.08, 0.09, 0.12);
  const auto note = colour(0.30, 0.33, 0.38);
  const auto pull = colour(0.80, 0.08, 0.08);
  const auto load = colour(0.05, 0.20, 0.75);
  const auto ghost = colour(0.05, 0.50, 0.20);
  const auto& f = g.measured.force;
  // In front of the wheel as the view has it, where neither rim nor soil hides the arrows.
  const Eigen::Vector3d root(g.hub.x(), -0.07, g.hub.z());
  const Eigen::Vector3d contact(g.hub.x(), -0.07, g.hub.z() - g.radius);
  const Eigen::Vector3d tip = root + newtons_to_metres * Eigen::Vector3d(f.x(), 0.0, 0.0);
  const Eigen::Vector3d top = contact + newtons_to_metres * Eigen::Vector3d(0.0, 0.0, f.z());
  MarkerArray array;
  auto& all = array.markers;
  all.push_back(arrow(0, root, tip, pull, 0.012));
  all.push_back(arrow(1, contact, top, load, 0.012));
  all.push_back(text(10, fmt::format("drawbar pull {:.1f} N", f.x()),
                     point(std::max(tip.x(), root.x()) + 0.17, -0.07, root.z()), 0.030, pull));
  all.push_back(text(11, fmt::format("normal load {:.1f} N", f.z()),
                     point(contact.x() - 0.22, -0.07, 0.5 * (contact.z() + top.z())), 0.030, load));
  if (g.has_twin) {
    const Eigen::Vector3d beside(root.x(), -0.07, root.z() - 0.05);
    const Eigen::Vector3d end = beside + newtons_to_metres * Eigen::Vector3d(g.twin.force.x(), 0.0, 0.0);
    all.push_back(arrow(2, beside, end, ghost, 0.008));
    all.push_back(text(13, fmt::format("twin {:.1f} N", g.twin.force.x()),
                       point(std::max(tip.x(), root.x()) + 0.13, -0.07, root.z() - 0.055), 0.028, ghost));
  }
  std::string numbers =
      fmt::format("{}\n{}\nt = {:.1f} s, slip {:.2f}\n\n", g.title, g.phase, g.time, g.slip);
  numbers += line("drawbar pull", f.x(), g.twin.force.x(), g.has_twin, "N") + "\n";
  numbers += line("normal load", f.z(), g.twin.force.z(), g.has_twin, "N") + "\n";
  numbers += line("side force", f.y(), g.twin.force.y(), g.has_twin, "N") + "\n";
  numbers += line("hub displacement", 1e3 * g.measured.hub_displacement, 1e3 * g.twin.hub_displacement,
                  g.has_twin, "mm") +
             "\n";
  numbers += line("motor torque", g.measured.motor_effort, g.twin.motor_effort, g.has_twin, "N m");
  all.push_back(text(12, numbers, point(-0.20, -0.40, 0.41), g.has_twin ? 0.025 : 0.028, ink));

  const double x = g.hub.x();
  const double sensor = g.hub.z() + 0.167;
  all.push_back(text(20, "belt-driven carriage", point(x + 0.27, -0.07, 0.594), 0.022, note));
  all.push_back(text(21, "draw wire", point(x + 0.215, -0.07, 0.50), 0.022, note));
  all.push_back(text(22, "slide with dead weights", point(x + 0.29, -0.07, g.hub.z() + 0.25), 0.022, note));
  all.push_back(text(23, "force/torque sensor", point(x + 0.26, -0.07, sensor), 0.022, note));
  all.push_back(text(24, "rut", point(0.12 * x, -0.085, 0.012), 0.026, note));
  return array;
}

}  // namespace wheel_twin::nodes
