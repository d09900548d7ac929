// A picture of curves and points as SVG: titled axes with units, round ticks, a legend; no program or library
// needed to make or see one (every browser shows it).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace wheel_twin {

struct PlotSeries {
  enum class Style { line, dashed, points };
  std::string label;  ///< in the legend; empty: not listed
  std::vector<double> x, y;
  Style style = Style::line;
  int color = -1;  ///< index in the palette of eight; -1: by position
};

struct Plot {
  std::string title;
  std::string x_label;  ///< with its unit
  std::string y_label;
  std::vector<PlotSeries> series;
  std::optional<std::pair<double, double>> x_range, y_range;  ///< else what the data need
  bool equal_scale = false;                                   ///< one metre is as long along x as along y
};

/// The picture as an <svg> element of the given size in pixels; can stand in an HTML page. Non-finite values
/// break a line and are left out otherwise.
std::string svg(const Plot& plot, int width = 720, int height = 440);

/// Several plots below one another in one file, written atomically.
void write_svg(const std::string& path, const std::vector<Plot>& plots, int width = 720, int height = 440);

}  // namespace wheel_twin
