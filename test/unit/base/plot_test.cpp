#include "base/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

namespace wheel_twin {
namespace {

TEST(Plot, PutsDataWhereTheAxesSay) {
  Plot plot;
  plot.x_range = std::make_pair(0.0, 10.0);
  plot.y_range = std::make_pair(0.0, 1.0);
  plot.series.push_back({"", {0.0, 10.0}, {0.0, 1.0}, PlotSeries::Style::line});
  // Frame: 78 px left, 20 right, 16 above, 56 below a picture of 500 x 300 without a title.
  EXPECT_NE(svg(plot, 500, 300).find("M78.0 244.0L480.0 16.0"), std::string::npos);
}

TEST(Plot, NonFiniteValuesBreakALine) {
  Plot plot;
  plot.x_range = std::make_pair(0.0, 4.0);
  plot.y_range = std::make_pair(0.0, 4.0);
  plot.series.push_back({"", {0.0, 1.0, 2.0, 3.0, 4.0}, {0.0, 1.0, std::nan(""), 3.0, 4.0}});
  const std::string text = svg(plot);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_TRUE(std::regex_search(text, std::regex("M[0-9. ]+L[0-9. ]+M[0-9. ]+L")));
}

TEST(Plot, EmptyAndConstantDataStillGiveAPicture) {
  EXPECT_NE(svg(Plot{}).find("</svg>"), std::string::npos);
  Plot flat;
  flat.series.push_back({"a < b & c", {1.0, 1.0}, {2.0, 2.0}});
  const std::string text = svg(flat);
  EXPECT_NE(text.find("a &lt; b &amp; c"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
}

}  // namespace
}  // namespace wheel_twin
