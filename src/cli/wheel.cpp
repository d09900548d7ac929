// `twin wheel`: torsion stiffness of a wheel's rim and beams, and its load-deflection curve on hard ground.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/atomic_file.h"
#include "base/config_path.h"
#include "base/error.h"
#include "base/plot.h"
#include "base/progress.h"
#include "cli/commands.h"
#include "wheel/calibration.h"
#include "wheel/ring_check.h"
#include "wheel/rolling_wheel.h"

namespace wheel_twin::cli {
namespace {

using nlohmann::json;
using wheel::Bending;
using wheel::WheelModel;

constexpr double kDegree = M_PI / 180.0;
constexpr double kPerDegree = 1000.0 * kDegree;  // N m/rad to N mm/deg

struct Options {
  std::string name = "amalia", out;
  double load = 0.0, angle = 0.0, most = 0.0;
  int points = 12;
};

struct Rule {
  Bending bending;
  const char* name;
  const char* meaning;
};
constexpr Rule kRules[] = {{Bending::printed, "printed", "the paper's procedure as printed"},
                           {Bending::beam, "beam", "E I / L"},
                           {Bending::plate, "plate", "E I / ((1 - nu^2) L)"}};

WheelModel flexible_model(const std::string& name) {
  const WheelModel model = wheel::read_wheel_file(find_config("wheels", name));
  if (model.suspension == wheel::Suspension::rigid)
    throw Error(fmt::format("wheel '{}' is rigid: there is no sheet whose stiffness could be found", name));
  return model;
}

/// `load`: of the printed procedure, N; 0: a small one.
double stiffness(const wheel::Sheet& sheet, Bending bending, int segments, double radius, double load) {
  const double rigidity = sheet.flexural_rigidity();
  if (bending == Bending::printed)
    return wheel::printed_stiffness(segments, radius, rigidity,
                                    load > 0.0 ? load : wheel::small_load(radius, rigidity));
  return wheel::bending_stiffness(sheet, bending, 2.0 * M_PI * radius / segments);
}

/// How much the multibody ring with a rule's joints gives way, over what thin-ring theory says of the sheet.
json ring(const WheelModel& model, double joint, double load) {
  WheelModel alone = wheel::free_ring(model);
  alone.rim_joint_stiffness = joint;
  const double rigidity = model.rim.flexural_rigidity();
  const wheel::DiameterChange twin = wheel::squeeze(alone, load);
  const wheel::DiameterChange exact = wheel::elastica(model.radius, rigidity, load);
  return {{"load_n", load},
          {"loaded_diameter_m", twin.loaded},
          {"loaded_diameter_elastica_m", exact.loaded},
          {"loaded_over_elastica", twin.loaded / exact.loaded},
          {"free_diameter_m", twin.free},
          {"free_diameter_elastica_m", exact.free},
          {"free_over_elastica", twin.free / exact.free}};
}

void calibrate(const Options& options) {
  const WheelModel model = flexible_model(options.name);
  if (options.load < 0.0) throw Error(fmt::format("--load is {:g} N: above 0 is needed", options.load));
  const double rigidity = model.rim.flexural_rigidity();
  json report{{"wheel", model.name},
              {"segments", model.segments},
              {"rim_flexural_rigidity_n_m2", rigidity},
              {"rim_joint_stiffness_in_file_n_mm_per_deg", model.rim_joint_stiffness * kPerDegree}};
  Plot plot;
  plot.title = fmt::format("Rim of {}, {} segments, under two opposite loads", model.name, model.segments);
  plot.x_label = "load (N)";
  plot.y_label = "shortening of the loaded diameter (mm)";
  const std::vector<double> shares = {0.001, 0.02, 0.05, 0.10, 0.15};
  PlotSeries exact{"elastica", {0.0}, {0.0}};
  for (const double share : shares) {
    const double w = wheel::elastica_load(model.radius, rigidity, share);
    exact.x.push_back(w);
    exact.y.push_back(2e3 * model.radius * share);
  }
  plot.series.push_back(exact);
  fmt::print("wheel {}: rim of {} segments, E I = {:.5g} N m^2, {:.2f} N mm/deg in its file\n", model.name,
             model.segments, rigidity, model.rim_joint_stiffness * kPerDegree);
  Progress progress("rings", 3.0 * static_cast<double>(shares.size()));
  double done = 0.0;
  for (const Rule& rule : kRules) {
    const double joint = stiffness(model.rim, rule.bending, model.segments, model.radius, options.load);
    json entry{{"meaning", rule.meaning}, {"rim_joint_stiffness_n_mm_per_deg", joint * kPerDegree}};
    PlotSeries series{rule.name, {}, {}, PlotSeries::Style::points};
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const json one = ring(model, joint, exact.x[i + 1]);
      series.x.push_back(exact.x[i + 1]);
      series.y.push_back(-1e3 * one["loaded_diameter_m"].get<double>());
      entry["ring"].push_back(one);
      progress.update(++done);
    }
    plot.series.push_back(series);
    std::string beams;
    if (model.suspension == wheel::Suspension::beams) {
      const double radius = 0.5 * (model.radius - model.hub_radius);
      const double beam = stiffness(model.beams.sheet, rule.bending, 2 * model.beams.bodies, radius, 0.0);
      entry["beam_joint_stiffness_n_mm_per_deg"] = beam * kPerDegree;
      beams = fmt::format(", beams {:.2f} N mm/deg", beam * kPerDegree);
    }
    fmt::print(
        "  {:8} rim {:.2f} N mm/deg{}; ring gives {:+.1f} % at 0.1 %, {:+.1f} % at 15 % of the "
        "diameter against the elastica ({})\n",
        rule.name, joint * kPerDegree, beams,
        100.0 * (entry["ring"].front()["loaded_over_elastica"].get<double>() - 1.0),
        100.0 * (entry["ring"].back()["loaded_over_elastica"].get<double>() - 1.0), rule.meaning);
    report["rules"][rule.name] = entry;
  }
  if (options.out.empty()) return;
  std::filesystem::create_directories(options.out);
  write_file(options.out + "/calibration.json", report.dump(2) + "\n");
  write_svg(options.out + "/calibration.svg", {plot});
}

void deflect(const Options& options) {
  const WheelModel model = wheel::read_wheel_file(find_config("wheels", options.name));
  if (!(options.most > 0.0)) throw Error(fmt::format("--load is {:g} N: above 0 is needed", options.most));
  if (options.points < 1) throw Error(fmt::format("--points is {}: at least 1 is needed", options.points));
  PlotSeries curve{"multibody wheel", {0.0}, {0.0}};
  json rows = json::array({{{"load_n", 0.0}, {"deflection_m", 0.0}}});
  std::vector<double> loads;
  for (int i = 1; i <= options.points; ++i) loads.push_back(options.most * i / options.points);
  Progress progress("loads", static_cast<double>(loads.size()));
  double done = 0.0;
  const auto points =
      wheel::load_deflection(model, loads, options.angle * kDegree, [&] { progress.update(++done); });
  for (const wheel::LoadPoint& point : points) {
    rows.push_back({{"load_n", point.load}, {"deflection_m", point.deflection}});
    curve.x.push_back(1e3 * point.deflection);
    curve.y.push_back(point.load);
  }
  const wheel::LoadPoint& last = points.back();
  if (last.deflection > 0.0)
    fmt::print("wheel {} on a hard floor: {:.3f} mm at {:g} N, {:.2f} N/mm\n", model.name,
               1e3 * last.deflection, last.load, 1e-3 * last.load / last.deflection);
  else
    fmt::print("wheel {} is rigid: no deflection at {:g} N\n", model.name, last.load);
  if (options.out.empty()) return;
  std::filesystem::create_directories(options.out);
  const json report{{"wheel", model.name},
                    {"segments", model.segments},
                    {"wheel_angle_deg", options.angle},
                    {"floor", "level, hard, frictionless"},
                    {"curve", rows}};
  write_file(options.out + "/deflection.json", report.dump(2) + "\n");
  Plot plot;
  plot.title = fmt::format("{} standing on a hard floor", model.name);
  plot.x_label = "hub deflection (mm)";
  plot.y_label = "load (N)";
  plot.series = {curve};
  write_svg(options.out + "/deflection.svg", {plot});
}

}  // namespace

void add_wheel(CLI::App& app) {
  CLI::App* command = app.add_subcommand("wheel", "Stiffness and deflection of a flexible wheel");
  command->require_subcommand(1);

  auto rim = std::make_shared<Options>();
  CLI::App* calibration = command->add_subcommand(
      "calibrate", "Torsion stiffness of rim and beams: the paper's procedure and the consistent ones");
  calibration->add_option("--wheel", rim->name, "name in config/wheels or a file")->capture_default_str();
  calibration->add_option("--load", rim->load,
                          "N, of the printed procedure, which depends on it (default: small, 0.01 % of the "
                          "diameter)");
  calibration->add_option("--out", rim->out, "folder for calibration.json and calibration.svg");
  calibration->footer("Example:\n  twin wheel calibrate --wheel t0_r0 --out out/t0_r0");
  calibration->callback([rim] { calibrate(*rim); });

  auto standing = std::make_shared<Options>();
  standing->most = 60.0;
  CLI::App* deflection =
      command->add_subcommand("deflect", "Load against deflection of a wheel standing on a hard floor");
  deflection->add_option("--wheel", standing->name, "name in config/wheels or a file")->capture_default_str();
  deflection->add_option("--load", standing->most, "highest load, N")->capture_default_str();
  deflection->add_option("--points", standing->points, "loads up to it")->capture_default_str();
  deflection->add_option("--angle", standing->angle, "of the wheel, degrees")->capture_default_str();
  deflection->add_option("--out", standing->out, "folder for deflection.json and deflection.svg");
  deflection->footer("Example:\n  twin wheel deflect --wheel amalia --load 61.7 --out out/amalia");
  deflection->callback([standing] { deflect(*standing); });
}

}  // namespace wheel_twin::cli
