#include "base/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/atomic_file.h"

namespace wheel_twin {
namespace {

// Okabe and Ito (2008): told apart by colour-blind readers.
constexpr std::array<const char*, 8> palette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                "#e69f00", "#56b4e9", "#000000", "#8a8a8a"};

struct Axis {
  double low = 0.0, high = 1.0, tick = 0.2;
  double at(double value) const { return (value - low) / (high - low); }
};

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += c;
  }
  return result;
}

double round_step(double raw) {
  const double magnitude = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (raw <= factor * magnitude * 1.0001) return factor * magnitude;
  return 10.0 * magnitude;
}

Axis make_axis(const Plot& plot, std::vector<double> PlotSeries::*values,
               const std::optional<std::pair<double, double>>& range, int ticks) {
  Axis axis;
  if (range) {
    axis.low = range->first;
    axis.high = range->second;
  } else {
    axis.low = std::numeric_limits<double>::infinity();
    axis.high = -axis.low;
    for (const PlotSeries& s : plot.series)
      for (const double v : s.*values)
        if (std::isfinite(v)) {
          axis.low = std::min(axis.low, v);
          axis.high = std::max(axis.high, v);
        }
    if (!(axis.low <= axis.high)) axis = {0.0, 1.0, 0.2};
  }
  if (axis.high - axis.low < 1e-12 * std::max(1e-9, std::abs(axis.high))) {
    const double pad = axis.high == 0.0 ? 1.0 : 0.1 * std::abs(axis.high);
    axis.low -= pad;
    axis.high += pad;
  }
  axis.tick = round_step((axis.high - axis.low) / ticks);
  if (!range) {
    axis.low = std::floor(axis.low / axis.tick + 1e-9) * axis.tick;
    axis.high = std::ceil(axis.high / axis.tick - 1e-9) * axis.tick;
  }
  return axis;
}

std::string tick_text(double value, double tick) {
  if (std::abs(value) < 1e-9 * tick) value = 0.0;
  return fmt::format("{:.6g}", value);
}

}  // namespace

std::string svg(const Plot& plot, int width, int height) {
  const double left = 78, right = 20, top = plot.title.empty() ? 16 : 40, bottom = 56;
  const double w = width - left - right;
  const double h = height - top - bottom;
  Axis x = make_axis(plot, &PlotSeries::x, plot.x_range, std::max(3, width / 110));
  Axis y = make_axis(plot, &PlotSeries::y, plot.y_range, std::max(3, height / 70));
  if (plot.equal_scale) {
    const double scale = std::max((x.high - x.low) / w, (y.high - y.low) / h);
    x.high = x.low + scale * w;
    y.high = y.low + scale * h;
  }
  const auto px = [&](double v) { return left + w * x.at(v); };
  const auto py = [&](double v) { return top + h * (1.0 - y.at(v)); };

  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"DejaVu Sans, Helvetica, sans-serif\" font-size=\"13\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      width, height);
  for (double v = std::ceil(x.low / x.tick - 1e-9) * x.tick; v <= x.high + 1e-9 * x.tick; v += x.tick)
    out += fmt::format(
        "<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"#e4e4e4\"/><text x=\"{0:.1f}\" y=\"{3:.1f}\" "
        "text-anchor=\"middle\">{4}</text>\n",
        px(v), top, top + h, top + h + 18, tick_text(v, x.tick));
  for (double v = std::ceil(y.low / y.tick - 1e-9) * y.tick; v <= y.high + 1e-9 * y.tick; v += y.tick)
    out += fmt::format(
        "<path d=\"M{1:.1f} {0:.1f}H{2:.1f}\" stroke=\"#e4e4e4\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5}</text>\n",
        py(v), left, left + w, left - 7, py(v) + 4.5, tick_text(v, y.tick));
  // Pictures share a page: an id names the area itself, so that equal ids clip equally.
  const std::string area = fmt::format("area_{:.0f}_{:.0f}_{:.0f}_{:.0f}", left, top, w, h);
  out += fmt::format(
      "<clipPath id=\"{}\"><rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" "
      "height=\"{:.0f}\"/></clipPath>\n",
      area, left - 5, top - 5, w + 10, h + 10);
  out += fmt::format("<g clip-path=\"url(#{})\">\n", area);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& s = plot.series[i];
    const char* color = palette[(s.color >= 0 ? s.color : static_cast<int>(i)) % palette.size()];
    const std::size_t count = std::min(s.x.size(), s.y.size());
    if (s.style == PlotSeries::Style::points) {
      for (std::size_t k = 0; k < count; ++k)
        if (std::isfinite(s.x[k]) && std::isfinite(s.y[k]))
          out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.2\" fill=\"{}\"/>\n", px(s.x[k]),
                             py(s.y[k]), color);
      continue;
    }
    std::string path;
    bool pen_down = false;
    for (std::size_t k = 0; k < count; ++k) {
      const bool good = std::isfinite(s.x[k]) && std::isfinite(s.y[k]);
      if (good) path += fmt::format("{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', px(s.x[k]), py(s.y[k]));
      pen_down = good;
    }
    out += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.7\"{}/>\n", path, color,
                       s.style == PlotSeries::Style::dashed ? " stroke-dasharray=\"6 4\"" : "");
  }
  out += "</g>\n";
  out += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"#444\"/>\n",
      left, top, w, h);
  out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", left + w / 2,
                     height - 14.0, escaped(plot.x_label));
  out +=
      fmt::format("<text transform=\"translate(18 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                  top + h / 2, escaped(plot.y_label));
  if (!plot.title.empty())
    out += fmt::format("<text x=\"{:.1f}\" y=\"24\" text-anchor=\"middle\" font-size=\"15\">{}</text>\n",
                       left + w / 2, escaped(plot.title));

  std::size_t entries = 0;
  std::size_t longest = 0;
  for (const PlotSeries& s : plot.series)
    if (!s.label.empty()) {
      ++entries;
      longest = std::max(longest, s.label.size());
    }
  if (entries > 0) {
    // The corner with the fewest data points under the legend.
    const double box_w = 48 + 8.0 * static_cast<double>(longest);
    const double box_h = 8 + 18.0 * static_cast<double>(entries);
    double best_x = 0, best_y = 0;
    std::size_t best_hits = std::numeric_limits<std::size_t>::max();
    for (const double corner_x : {left + w - box_w - 8, left + 8})
      for (const double corner_y : {top + 8, top + h - box_h - 8}) {
        std::size_t hits = 0;
        for (const PlotSeries& s : plot.series)
          for (std::size_t k = 0; k < std::min(s.x.size(), s.y.size()); ++k) {
            const double u = px(s.x[k]);
            const double v = py(s.y[k]);
            hits +=
                u > corner_x - 4 && u < corner_x + box_w + 4 && v > corner_y - 4 && v < corner_y + box_h + 4;
          }
        if (hits < best_hits) {
          best_hits = hits;
          best_x = corner_x;
          best_y = corner_y;
        }
      }
    out += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"white\" "
        "fill-opacity=\"0.85\" "
        "stroke=\"#bbb\"/>\n",
        best_x, best_y, box_w, box_h);
    double line = best_y + 17;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
      const PlotSeries& s = plot.series[i];
      if (s.label.empty()) continue;
      const char* color = palette[(s.color >= 0 ? s.color : static_cast<int>(i)) % palette.size()];
      if (s.style == PlotSeries::Style::points)
        out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.2\" fill=\"{}\"/>", best_x + 20,
                           line - 4.5, color);
      else
        out += fmt::format("<path d=\"M{:.1f} {:.1f}h24\" stroke=\"{}\" stroke-width=\"2\"{}/>", best_x + 8,
                           line - 4.5, color,
                           s.style == PlotSeries::Style::dashed ? " stroke-dasharray=\"6 4\"" : "");
      out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", best_x + 38, line, escaped(s.label));
      line += 18;
    }
  }
  return out + "</svg>\n";
}

void write_svg(const std::string& path, const std::vector<Plot>& plots, int width, int height) {
  const int count = static_cast<int>(plots.size());
  std::string out = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\">\n",
                                width, height * count);
  for (int i = 0; i < count; ++i)
    out +=
        fmt::format("<g transform=\"translate(0 {})\">\n{}</g>\n", i * height, svg(plots[i], width, height));
  write_file(path, out + "</svg>\n");
}

}  // namespace wheel_twin
