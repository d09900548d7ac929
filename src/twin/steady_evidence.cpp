#include "twin/steady_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace wheel_twin::twin {
namespace {

struct Band {
  const char* name;
  double low, high;
};
constexpr Band bands[] = {{"locked wheel (slip below -0.9)", -1.01, -0.9},
                          {"braking (slip -0.9 to -0.05)", -0.9, -0.05},
                          {"free rolling (slip about 0)", -0.05, 0.05},
                          {"driving (slip 0.05 to 0.6)", 0.05, 0.6},
                          {"spinning (slip above 0.6)", 0.6, 1.01}};

struct Point {
  double x = 0.0, residual = 0.0;
};

std::vector<Point> points_of(const std::vector<SteadyRow>& rows, Channel channel,
                             double SteadyRow::Value::*twin, double SteadyRow::*x) {
  std::vector<Point> points;
  for (const SteadyRow& row : rows) {
    const auto value = row.values.find(channel);
    if (value != row.values.end() && std::isfinite(value->second.*twin))
      points.push_back({row.*x, value->second.measured - value->second.*twin});
  }
  return points;
}

double correlation(const std::vector<Point>& points) {
  const double n = static_cast<double>(points.size());
  double mx = 0.0, my = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
  for (const Point& p : points) mx += p.x / n, my += p.residual / n;
  for (const Point& p : points) {
    xx += (p.x - mx) * (p.x - mx);
    yy += (p.residual - my) * (p.residual - my);
    xy += (p.x - mx) * (p.residual - my);
  }
  return xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
}

/// Correlation beyond chance by Fisher's transform, with Bonferroni's correction for `asked` questions.
bool beyond_chance(double r, std::size_t runs, double asked) {
  if (runs < 6) return false;
  const double z = std::atanh(std::min(0.999999, std::abs(r))) * std::sqrt(static_cast<double>(runs) - 3.0);
  return asked * std::erfc(z / std::sqrt(2.0)) < 0.05;
}

}  // namespace

std::string describe_by_slip(const std::vector<SteadyRow>& rows, const SteadyNoise& noise,
                             double SteadyRow::Value::*twin) {
  struct Part {
    double z;
    std::string text;
  };
  std::vector<Part> parts;
  for (const Channel channel : all_channels) {
    const std::vector<Point> points = points_of(rows, channel, twin, &SteadyRow::slip);
    for (const Band& band : bands) {
      double sum = 0.0, count = 0.0;
      for (const Point& p : points)
        if (p.x > band.low && p.x <= band.high) sum += p.residual, count += 1.0;
      if (count == 0.0) continue;
      const double z = sum / std::sqrt(count) / noise[index_of(channel)].total();
      if (std::abs(z) < 4.0) continue;
      parts.push_back(
          {std::abs(z), fmt::format("{}: {} is {:+.3g} {} off the twin over {:.0f} run{}", band.name,
                                    name_of(channel), shown_factor(channel) * sum / count,
                                    shown_unit_of(channel), count, count > 1.0 ? "s" : "")});
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.z > b.z; });
  if (parts.size() > 5) parts.resize(5);
  std::string text;
  for (const Part& part : parts) text += (text.empty() ? "" : "; ") + part.text;
  return text;
}

std::string describe_correlations(const std::vector<SteadyRow>& rows, const SteadyNoise& noise,
                                  double SteadyRow::Value::*twin) {
  std::string text;
  for (const Channel channel : all_channels) {
    const char* names[] = {"slip", "load", "steering angle"};
    double SteadyRow::*members[] = {&SteadyRow::slip, &SteadyRow::load, &SteadyRow::steering_angle};
    for (int k = 0; k < 3; ++k) {
      const std::vector<Point> points = points_of(rows, channel, twin, members[k]);
      const double r = correlation(points);
      if (beyond_chance(r, points.size(), 3.0 * channel_count))
        text += fmt::format("{}{} goes along with {} (correlation {:+.2f})", text.empty() ? "" : "; ",
                            name_of(channel), names[k], r);
    }
    // Groups: the mean of each against the scatter between runs of one group.
    std::map<std::string, std::vector<double>> groups;
    for (const SteadyRow& row : rows) {
      const auto value = row.values.find(channel);
      if (value != row.values.end() && !row.group.empty() && std::isfinite(value->second.*twin))
        groups[row.group].push_back(value->second.measured - value->second.*twin);
    }
    std::string worst;
    double worst_z = 0.0, worst_mean = 0.0;
    for (const auto& [group, values] : groups) {
      if (values.size() < 2) continue;
      double mean = 0.0;
      for (const double v : values) mean += v / static_cast<double>(values.size());
      const double z =
          mean * std::sqrt(static_cast<double>(values.size())) / noise[index_of(channel)].independent();
      if (std::abs(z) > std::abs(worst_z)) worst = group, worst_z = z, worst_mean = mean;
    }
    if (!worst.empty() &&
        static_cast<double>(groups.size() * channel_count) * std::erfc(std::abs(worst_z) / std::sqrt(2.0)) <
            0.05)
      text +=
          fmt::format("{}{} of {} lies {:+.3g} {} off as a whole", text.empty() ? "" : "; ", name_of(channel),
                      worst, shown_factor(channel) * worst_mean, shown_unit_of(channel));
  }
  return text;
}

}  // namespace wheel_twin::twin
