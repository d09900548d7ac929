#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/atomic_file.h"
#include "base/plot.h"
#include "bulk/calibrate.h"
#include "bulk/folder.h"

namespace wheel_twin::bulk {
namespace {

constexpr std::array<const char*, quantity_count> units = {"Pa", "rad", "rad"};

}  // namespace

void write_calibration(const std::string& folder, const dem::GranularSoil& soil, const Measurements& measured,
                       const Calibration& c) {
  make_folder(folder);
  std::string csv = "friction,shear_modulus_pa,cohesion_pa,friction_angle_rad,angle_of_repose_rad\n";
  PlotSeries simulated{"simulated", {}, {}, PlotSeries::Style::points};
  for (const Evaluation& e : c.evaluations) {
    csv += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", e.at.friction, e.at.shear_modulus, e.value[0],
                       e.value[1], e.value[2]);
    simulated.x.push_back(e.at.friction);
    simulated.y.push_back(std::log10(e.at.shear_modulus));
  }
  write_file(folder + "/evaluations.csv", csv);

  const auto number = [](double v) {
    return std::isfinite(v) ? nlohmann::ordered_json(v) : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json quantities;
  for (std::size_t q = 0; q < quantity_count; ++q)
    if (measured[q])
      quantities[quantity_names[q]] = {{"unit", units[q]},
                                       {"measured", measured[q]->value},
                                       {"measured_stderr", measured[q]->error},
                                       {"simulated", number(c.predicted[q])},
                                       {"simulated_stderr", number(c.predicted_error[q])}};
  const auto interval = [](const Marginal& m) {
    return nlohmann::ordered_json{
        {"mean", m.mean}, {"low_90", m.low}, {"high_90", m.high}, {"determined", m.determined}};
  };
  const nlohmann::ordered_json json = {
      {"schema", 1},
      {"soil", soil.name},
      {"simulated_parameter_sets", c.evaluations.size()},
      {"best",
       {{"friction", c.best.friction}, {"shear_modulus", {{"value", c.best.shear_modulus}, {"unit", "Pa"}}}}},
      {"friction", interval(c.friction)},
      {"log10_shear_modulus", interval(c.log10_modulus)},
      {"correlation", c.correlation},
      {"quantities", quantities},
      {"undetermined", c.undetermined}};
  write_file(folder + "/calibration.json", json.dump(2) + "\n");

  // Marginal probabilities, and the points on the way.
  Plot points{fmt::format("Calibration, {}", soil.name),
              "friction coefficient",
              "log10 of the shear modulus (Pa)",
              {simulated},
              {},
              {}};
  points.series.push_back(
      {"most probable", {c.best.friction}, {std::log10(c.best.shear_modulus)}, PlotSeries::Style::points});
  Plot friction{"", "friction coefficient", "probability of a cell", {}, {}, {}};
  Plot modulus{"", "log10 of the shear modulus (Pa)", "probability of a cell", {}, {}, {}};
  PlotSeries over_friction{"", c.grid_friction, std::vector<double>(c.grid_friction.size(), 0.0)};
  PlotSeries over_modulus{"", c.grid_log10_modulus, std::vector<double>(c.grid_log10_modulus.size(), 0.0)};
  const std::size_t columns = c.grid_friction.size();
  for (std::size_t k = 0; k < c.posterior.size(); ++k) {
    over_friction.y[k % columns] += c.posterior[k];
    over_modulus.y[k / columns] += c.posterior[k];
  }
  friction.series.push_back(over_friction);
  modulus.series.push_back(over_modulus);
  write_svg(folder + "/calibration.svg", {points, friction, modulus});
}

}  // namespace wheel_twin::bulk
