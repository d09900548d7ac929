#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/atomic_file.h"
#include "base/plot.h"
#include "bulk/direct_shear.h"
#include "bulk/folder.h"

namespace wheel_twin::bulk {

void write_shear_report(const std::string& folder, const dem::GranularSoil& soil, const ShearSettings& s,
                        const ShearResult& result) {
  constexpr double degrees = 180.0 / 3.14159265358979323846;
  make_folder(folder);
  std::string csv = "normal_stress_pa,travel_m,shear_stress_pa,plate_stress_pa,plate_rise_m\n";
  for (const ShearCurve& c : result.curves)
    for (std::size_t i = 0; i < c.travel.size(); ++i)
      csv += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", c.normal_stress, c.travel[i],
                         c.shear_stress[i], c.plate_stress[i], c.plate_rise[i]);
  write_file(folder + "/curves.csv", csv);

  Plot curves{fmt::format("Direct shear, {}", soil.name),
              "travel of the lower frame (mm)",
              "shear stress (kPa)",
              {},
              {},
              {}};
  Plot dilation{"", "travel of the lower frame (mm)", "rise of the top plate (mm)", {}, {}, {}};
  PlotSeries peaks{"peak", {}, {}, PlotSeries::Style::points};
  nlohmann::ordered_json tests = nlohmann::ordered_json::array();
  double largest = 0.0;
  for (const ShearCurve& c : result.curves) {
    PlotSeries stress{fmt::format("{:.0f} kPa", c.normal_stress / 1e3), {}, {}};
    PlotSeries rise = stress;
    for (std::size_t i = 0; i < c.travel.size(); ++i) {
      stress.x.push_back(1e3 * c.travel[i]);
      stress.y.push_back(c.shear_stress[i] / 1e3);
      rise.y.push_back(1e3 * c.plate_rise[i]);
    }
    rise.x = stress.x;
    curves.series.push_back(stress);
    dilation.series.push_back(rise);
    peaks.x.push_back(c.normal_stress / 1e3);
    peaks.y.push_back(c.peak_shear_stress / 1e3);
    largest = std::max(largest, c.normal_stress);
    tests.push_back({{"normal_stress", {{"value", c.normal_stress}, {"unit", "Pa"}}},
                     {"peak_shear_stress", {{"value", c.peak_shear_stress}, {"unit", "Pa"}}},
                     {"final_shear_stress", {{"value", c.final_shear_stress}, {"unit", "Pa"}}},
                     {"void_ratio_consolidated", c.void_ratio_consolidated}});
  }
  Plot line{"", "normal stress (kPa)", "peak shear stress (kPa)", {peaks}, {}, {}};
  if (result.curves.size() > 1) {
    const double end = 1.1 * largest;
    line.series.push_back(
        {fmt::format("c = {:.2f} kPa, phi = {:.2f} deg", result.cohesion() / 1e3,
                     result.friction_angle() * degrees),
         {0.0, end / 1e3},
         {result.cohesion() / 1e3, (result.cohesion() + result.failure_line.slope * end) / 1e3}});
  }
  write_svg(folder + "/direct_shear.svg", {curves, dilation, line});

  const nlohmann::ordered_json json = {
      {"schema", 1},
      {"test", "direct_shear"},
      {"soil", soil.name},
      {"clumps", result.sample.clumps},
      {"box", {{"length", s.length}, {"width", s.width}, {"height", s.height}, {"unit", "m"}}},
      {"rate", {{"value", s.rate}, {"unit", "m/s"}}},
      {"travel", {{"value", s.travel}, {"unit", "m"}}},
      {"seed", s.seed},
      {"friction_while_filling", result.sample.fill_friction},
      {"void_ratio", result.sample.void_ratio},
      {"cohesion",
       {{"value", result.cohesion()}, {"stderr", result.failure_line.intercept_error}, {"unit", "Pa"}}},
      {"friction_angle",
       {{"value", result.friction_angle()},
        {"stderr", result.friction_angle_error()},
        {"unit", "rad"},
        {"degrees", result.friction_angle() * degrees}}},
      {"tests", tests}};
  write_file(folder + "/direct_shear.json", json.dump(2) + "\n");
}

}  // namespace wheel_twin::bulk
