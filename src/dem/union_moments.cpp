// Moments of a union of spheres; the method stands in clump_template.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dem/clump_template.h"

namespace wheel_twin::dem {
namespace {

constexpr double pi = 3.14159265358979323846;

struct Rule {
  std::vector<double> nodes;  // in (-1, 1)
  std::vector<double> weights;
};

// Gauss-Legendre rule by Newton iteration on the Legendre recurrence.
Rule gauss_legendre(int count) {
  Rule rule;
  rule.nodes.resize(count);
  rule.weights.resize(count);
  for (int i = 0; i < count; ++i) {
    double x = std::cos(pi * (i + 0.75) / (count + 0.5));
    double slope = 0.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p0 = 1.0;
      double p1 = x;
      for (int k = 2; k <= count; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      slope = count * (x * p1 - p0) / (x * x - 1.0);
      const double step = p1 / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    rule.nodes[i] = x;
    rule.weights[i] = 2.0 / ((1.0 - x * x) * slope * slope);
  }
  return rule;
}

// Raw moments of a plane figure.
struct PlaneMoments {
  double area = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
};

struct Disc {
  double x, y, r;
};

// Boundary integral (Green) over the arc of `disc` from angle `begin` to `end`, counter-clockwise.
void add_arc(const Disc& disc, double begin, double end, const Rule& rule, PlaneMoments& m) {
  const int pieces = std::max(1, static_cast<int>(std::ceil((end - begin) / (0.5 * pi))));
  const double half = 0.5 * (end - begin) / pieces;
  for (int p = 0; p < pieces; ++p) {
    const double middle = begin + (2 * p + 1) * half;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const double angle = middle + half * rule.nodes[i];
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      const double x = disc.x + disc.r * c;
      const double y = disc.y + disc.r * s;
      const double w = half * rule.weights[i] * disc.r;  // dx = -w s, dy = w c
      m.area += w * 0.5 * (x * c + y * s);
      m.x += w * 0.5 * x * x * c;
      m.y += w * 0.5 * y * y * s;
      m.xx += w * x * x * x * c / 3.0;
      m.yy += w * y * y * y * s / 3.0;
      m.xy += w * 0.5 * x * x * y * c;
    }
  }
}

PlaneMoments union_of_discs(const std::vector<Disc>& discs, const Rule& arc_rule) {
  PlaneMoments moments;
  std::vector<std::array<double, 2>> covered;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const Disc& a = discs[i];
    covered.clear();
    bool hidden = false;
    for (std::size_t j = 0; j < discs.size() && !hidden; ++j) {
      if (j == i) continue;
      const Disc& b = discs[j];
      const double d = std::hypot(b.x - a.x, b.y - a.y);
      if (d >= a.r + b.r || d + b.r < a.r) continue;
      if (d + a.r <= b.r) {
        hidden = d + a.r < b.r || j < i;  // of two equal discs the first one counts
        continue;
      }
      const double towards = std::atan2(b.y - a.y, b.x - a.x);
      const double half = std::acos(std::clamp((d * d + a.r * a.r - b.r * b.r) / (2.0 * d * a.r), -1.0, 1.0));
      double begin = towards - half;
      if (begin < 0.0) begin += 2.0 * pi;
      const double end = begin + 2.0 * half;
      covered.push_back({begin, std::min(end, 2.0 * pi)});
      if (end > 2.0 * pi) covered.push_back({0.0, end - 2.0 * pi});
    }
    if (hidden) continue;
    std::sort(covered.begin(), covered.end());
    double position = 0.0;
    for (const auto& arc : covered) {
      if (arc[0] > position) add_arc(a, position, arc[0], arc_rule, moments);
      position = std::max(position, arc[1]);
    }
    if (position < 2.0 * pi) add_arc(a, position, 2.0 * pi, arc_rule, moments);
  }
  return moments;
}

bool is_inside(const ClumpSphere& inner, const ClumpSphere& outer) {
  return (inner.center - outer.center).norm() + inner.radius <= outer.radius;
}

// Spheres that add nothing to the union are left out.
std::vector<ClumpSphere> exposed(const std::vector<ClumpSphere>& spheres) {
  std::vector<ClumpSphere> kept;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    bool hidden = false;
    for (std::size_t j = 0; j < spheres.size() && !hidden; ++j)
      hidden = j != i && is_inside(spheres[i], spheres[j]) && (!is_inside(spheres[j], spheres[i]) || j < i);
    if (!hidden) kept.push_back(spheres[i]);
  }
  return kept;
}

// Heights at which the cross-section changes its shape: poles of the spheres, the lowest and highest points
// of the circles in which two spheres meet, and the points in which three meet.
std::vector<double> critical_heights(const std::vector<ClumpSphere>& s) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < s.size(); ++i) {
    heights.push_back(s[i].center.z() - s[i].radius);
    heights.push_back(s[i].center.z() + s[i].radius);
    for (std::size_t j = i + 1; j < s.size(); ++j) {
      const Eigen::Vector3d offset = s[j].center - s[i].center;
      const double d = offset.norm();
      const double along = (d * d + s[i].radius * s[i].radius - s[j].radius * s[j].radius) / (2.0 * d);
      const double circle_squared = s[i].radius * s[i].radius - along * along;
      if (!(circle_squared > 0.0)) continue;
      const Eigen::Vector3d normal = offset / d;
      const Eigen::Vector3d middle = s[i].center + along * normal;
      const double rise = std::sqrt(circle_squared * std::max(0.0, 1.0 - normal.z() * normal.z()));
      heights.push_back(middle.z() - rise);
      heights.push_back(middle.z() + rise);
      for (std::size_t k = j + 1; k < s.size(); ++k) {
        // Points of the circle at distance r_k from the third centre.
        const Eigen::Vector3d to_third = s[k].center - middle;
        const Eigen::Vector3d in_plane = to_third - to_third.dot(normal) * normal;
        const double length = in_plane.norm();
        if (length == 0.0) continue;
        const double cosine = (circle_squared + to_third.squaredNorm() - s[k].radius * s[k].radius) /
                              (2.0 * std::sqrt(circle_squared) * length);
        if (std::abs(cosine) >= 1.0) continue;
        const Eigen::Vector3d u = in_plane / length;
        const Eigen::Vector3d v = normal.cross(u);
        const double sine = std::sqrt(1.0 - cosine * cosine);
        heights.push_back(middle.z() + std::sqrt(circle_squared) * (cosine * u.z() + sine * v.z()));
        heights.push_back(middle.z() + std::sqrt(circle_squared) * (cosine * u.z() - sine * v.z()));
      }
    }
  }
  std::sort(heights.begin(), heights.end());
  return heights;
}

VolumeMoments about_centroid(double volume, const Eigen::Vector3d& first, const Eigen::Matrix3d& second) {
  VolumeMoments moments;
  moments.volume = volume;
  moments.centroid = first / volume;
  const Eigen::Matrix3d central = second - volume * moments.centroid * moments.centroid.transpose();
  moments.inertia = central.trace() * Eigen::Matrix3d::Identity() - central;
  return moments;
}

}  // namespace

VolumeMoments union_of_two(const ClumpSphere& a, const ClumpSphere& b) {
  const Eigen::Vector3d offset = b.center - a.center;
  const double d = offset.norm();
  // Each sphere gives the segment between `low` and `high` along the axis, measured from its own centre.
  double low_a = -a.radius, high_a = a.radius, low_b = -b.radius, high_b = b.radius;
  if (d + b.radius <= a.radius) {
    high_b = low_b;
  } else if (d + a.radius <= b.radius) {
    high_a = low_a;
  } else if (d < a.radius + b.radius) {
    const double plane = (d * d + a.radius * a.radius - b.radius * b.radius) / (2.0 * d);
    high_a = plane;
    low_b = plane - d;
  }
  const Eigen::Vector3d axis = d > 0.0 ? Eigen::Vector3d(offset / d) : Eigen::Vector3d::UnitX();
  double volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();  // about the centre of a
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  const auto add_segment = [&](double r, double low, double high, double shift) {
    const auto power = [&](int n) { return (std::pow(high, n) - std::pow(low, n)) / n; };
    const double v = pi * (r * r * power(1) - power(3));
    const double m1 = pi * (r * r * power(2) - power(4));
    const double m2 = pi * (r * r * power(3) - power(5));
    const double across = 0.25 * pi * (r * r * r * r * power(1) - 2.0 * r * r * power(3) + power(5));
    volume += v;
    first += (m1 + shift * v) * axis;
    second += (m2 + 2.0 * shift * m1 + shift * shift * v) * axis * axis.transpose() +
              across * (Eigen::Matrix3d::Identity() - axis * axis.transpose());
  };
  add_segment(a.radius, low_a, high_a, 0.0);
  add_segment(b.radius, low_b, high_b, d);
  VolumeMoments moments = about_centroid(volume, first, second);
  moments.centroid += a.center;
  return moments;
}

VolumeMoments union_by_slices(const std::vector<ClumpSphere>& all, int nodes) {
  const std::vector<ClumpSphere> spheres = exposed(all);
  const std::vector<double> heights = critical_heights(spheres);
  const Rule rule = gauss_legendre(nodes);
  const Rule arc_rule = gauss_legendre(12);
  double volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  std::vector<Disc> discs;
  const Eigen::Vector3d origin = spheres.front().center;
  for (std::size_t piece = 0; piece + 1 < heights.size(); ++piece) {
    const double half = 0.5 * (heights[piece + 1] - heights[piece]);
    const double middle = 0.5 * (heights[piece + 1] + heights[piece]);
    if (!(half > 0.0)) continue;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      // z = middle + half sin(u) takes the square roots at the ends of the piece away.
      const double u = 0.5 * pi * rule.nodes[i];
      const double z = middle + half * std::sin(u);
      const double weight = 0.5 * pi * rule.weights[i] * half * std::cos(u);
      discs.clear();
      for (const ClumpSphere& s : spheres) {
        const double squared = s.radius * s.radius - (z - s.center.z()) * (z - s.center.z());
        if (squared > 0.0)
          discs.push_back({s.center.x() - origin.x(), s.center.y() - origin.y(), std::sqrt(squared)});
      }
      const PlaneMoments m = union_of_discs(discs, arc_rule);
      const double h = z - origin.z();
      volume += weight * m.area;
      first += weight * Eigen::Vector3d(m.x, m.y, h * m.area);
      second(0, 0) += weight * m.xx;
      second(1, 1) += weight * m.yy;
      second(2, 2) += weight * h * h * m.area;
      second(0, 1) += weight * m.xy;
      second(0, 2) += weight * h * m.x;
      second(1, 2) += weight * h * m.y;
    }
  }
  second(1, 0) = second(0, 1);
  second(2, 0) = second(0, 2);
  second(2, 1) = second(1, 2);
  VolumeMoments moments = about_centroid(volume, first, second);
  moments.centroid += origin;
  return moments;
}

}  // namespace wheel_twin::dem
