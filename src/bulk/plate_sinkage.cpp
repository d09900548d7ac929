#include "bulk/plate_sinkage.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/plot.h"
#include "base/progress.h"
#include "bulk/folder.h"
#include "dem/limits.h"

namespace wheel_twin::bulk {
namespace {

constexpr double pi = 3.14159265358979323846;

SinkageCurve press(const dem::GranularSoil& soil, const dem::Bed& bed, const SinkageSettings& s,
                   double diameter, const std::function<void(double)>& progress) {
  const double radius = 0.5 * diameter;
  dem::System system = bed_system(soil, bed, 0.02, s.threads);
  double top = 0.0;
  for (const dem::SphereState& sphere : system.spheres()) {
    const double distance = std::hypot(sphere.center.x() - 0.5 * bed.settings.length, sphere.center.y());
    if (distance < radius + sphere.radius) top = std::max(top, sphere.center.z() + sphere.radius);
  }
  dem::Wall plate;
  plate.name = "plate";
  plate.material = dem::GranularSoil::wall_material;
  // A low cylinder with a flat face: soil that flows over the rim meets its side.
  plate.shape = dem::Revolved{
      {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(radius, 0.0), Eigen::Vector2d(radius, 0.015)}};
  plate.pose.position = {0.5 * bed.settings.length, 0.0, top + 1e-5};
  plate.motion.velocity.z() = -s.rate;
  const std::uint32_t number = system.add_wall(plate);

  SinkageCurve curve;
  curve.diameter = diameter;
  constexpr int block = 10;
  const double resolution = s.sinkage / 200.0;
  double next = -top;
  double sum = 0.0;
  int count = 0;
  for (;;) {
    system.step(block);
    const double sinkage = -system.wall(number).pose.position.z();
    sum += system.wall_wrench(number).force.z();
    ++count;
    if (progress) progress((sinkage + top) / (s.sinkage + top));
    if (sinkage < next) continue;
    curve.sinkage.push_back(sinkage);
    curve.pressure.push_back(sum / count / (pi * radius * radius));
    sum = 0.0;
    count = 0;
    next = sinkage + resolution;
    if (sinkage >= s.sinkage) return curve;
  }
}

}  // namespace

SinkageResult fit_bekker(std::vector<SinkageCurve> curves) {
  // log p = log k_i + n log z: n and one modulus a plate.
  const std::size_t plates = curves.size();
  double deepest = 0.0;
  for (const SinkageCurve& c : curves)
    for (const double z : c.sinkage) deepest = std::max(deepest, z);
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> values;
  for (std::size_t i = 0; i < plates; ++i)
    for (std::size_t k = 0; k < curves[i].sinkage.size(); ++k) {
      const double z = curves[i].sinkage[k];
      const double p = curves[i].pressure[k];
      if (z < 0.1 * deepest || !(p > 0.0)) continue;
      Eigen::VectorXd row = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(plates) + 1);
      row[0] = std::log(z);
      row[static_cast<Eigen::Index>(i) + 1] = 1.0;
      rows.push_back(row);
      values.push_back(std::log(p));
    }
  if (rows.size() < plates + 2) throw Error("plate sinkage: too few points for a fit");
  Eigen::MatrixXd a(rows.size(), plates + 1);
  Eigen::VectorXd b(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    a.row(static_cast<Eigen::Index>(i)) = rows[i];
    b[static_cast<Eigen::Index>(i)] = values[i];
  }
  const Eigen::VectorXd solution = a.colPivHouseholderQr().solve(b);
  SinkageResult result;
  result.n = solution[0];
  // k_i = k_c / b_i + k_phi with b the radius.
  if (plates == 1) {
    result.k_phi = std::exp(solution[1]);
  } else {
    Eigen::MatrixXd m(plates, 2);
    Eigen::VectorXd k(plates);
    for (std::size_t i = 0; i < plates; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      m(row, 0) = 2.0 / curves[i].diameter;
      m(row, 1) = 1.0;
      k[row] = std::exp(solution[row + 1]);
    }
    const Eigen::VectorXd moduli = m.colPivHouseholderQr().solve(k);
    result.k_c = moduli[0];
    result.k_phi = moduli[1];
  }
  result.curves = std::move(curves);
  return result;
}

SinkageResult plate_sinkage(const dem::GranularSoil& soil, const SinkageSettings& s) {
  dem::BedSettings settings;
  settings.length = settings.width = s.bed_size;
  settings.depth = s.bed_depth;
  settings.seed = s.seed;
  for (const double diameter : s.diameters)
    if (!(diameter > 0.0) || diameter > 0.5 * s.bed_size)
      throw Error(fmt::format(
          "plate sinkage: a plate of {} m needs a bed of at least twice its diameter, this one has {} m",
          diameter, s.bed_size));
  dem::check_positive("plate sinkage: rate (m/s)", s.rate, 1.0);
  dem::check_positive("plate sinkage: sinkage (m), at most half of the bed's depth,", s.sinkage,
                      0.5 * s.bed_depth);
  const dem::Bed bed = fetch_bed(soil, settings, s.threads);
  Progress progress("plate sinkage", static_cast<double>(s.diameters.size()));
  std::vector<SinkageCurve> curves;
  for (const double diameter : s.diameters) {
    const auto before = static_cast<double>(curves.size());
    curves.push_back(
        press(soil, bed, s, diameter, [&](double fraction) { progress.update(before + fraction); }));
  }
  return fit_bekker(std::move(curves));
}

void write_sinkage_report(const std::string& folder, const dem::GranularSoil& soil, const SinkageSettings& s,
                          const SinkageResult& result) {
  make_folder(folder);
  std::string csv = "diameter_m,sinkage_m,pressure_pa\n";
  Plot plot{fmt::format("Plate sinkage, {}", soil.name), "sinkage (mm)", "pressure (kPa)", {}, {}, {}};
  int color = 0;
  for (const SinkageCurve& c : result.curves) {
    PlotSeries measured{fmt::format("{:.0f} mm", 1e3 * c.diameter), {}, {}};
    PlotSeries fitted{"", {}, {}, PlotSeries::Style::dashed};
    measured.color = fitted.color = color++;
    for (std::size_t i = 0; i < c.sinkage.size(); ++i) {
      csv += fmt::format("{:.6g},{:.6g},{:.6g}\n", c.diameter, c.sinkage[i], c.pressure[i]);
      measured.x.push_back(1e3 * c.sinkage[i]);
      measured.y.push_back(c.pressure[i] / 1e3);
      if (c.sinkage[i] <= 0.0) continue;
      fitted.x.push_back(1e3 * c.sinkage[i]);
      fitted.y.push_back((2.0 * result.k_c / c.diameter + result.k_phi) * std::pow(c.sinkage[i], result.n) /
                         1e3);
    }
    plot.series.push_back(measured);
    plot.series.push_back(fitted);
  }
  write_file(folder + "/curves.csv", csv);
  write_svg(folder + "/plate_sinkage.svg", {plot});
  const nlohmann::ordered_json json = {{"schema", 1},
                                       {"test", "plate_sinkage"},
                                       {"soil", soil.name},
                                       {"diameters", s.diameters},
                                       {"rate", {{"value", s.rate}, {"unit", "m/s"}}},
                                       {"seed", s.seed},
                                       {"n", result.n},
                                       {"k_c", {{"value", result.k_c}, {"unit", "N/m^(n+1)"}}},
                                       {"k_phi", {{"value", result.k_phi}, {"unit", "N/m^(n+2)"}}}};
  write_file(folder + "/plate_sinkage.json", json.dump(2) + "\n");
}

}  // namespace wheel_twin::bulk
