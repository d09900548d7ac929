#include "twin/log_survey.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.h"
#include "logs/bag_reader.h"
#include "twin/metrics.h"
#include "twin/page.h"
#include "twin/plate_fit.h"
#include "twin/steady_runs.h"

namespace wheel_twin::twin {
namespace {

namespace fs = std::filesystem;

/// Least squares of y on columns, with standard errors; empty when the columns do not determine it.
struct Regression {
  Eigen::VectorXd value, error;
  double scatter = 0.0;
};
Regression regress(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  Regression r;
  const auto freedom = static_cast<double>(columns.rows() - columns.cols());
  if (freedom < 2.0) return r;
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(normal);
  if (!lu.isInvertible()) return r;
  const Eigen::MatrixXd inverse = lu.inverse();
  r.value = inverse * columns.transpose() * y;
  r.scatter = std::sqrt((y - columns * r.value).squaredNorm() / freedom);
  r.error = r.scatter * inverse.diagonal().cwiseSqrt();
  return r;
}

struct Line {
  double offset = 0.0, offset_error = 0.0, slope = 0.0, slope_error = 0.0, scatter = 0.0;
  std::size_t count = 0;
};
std::optional<Line> line_of(const std::vector<double>& x, const std::vector<double>& y) {
  if (x.size() < 5) return std::nullopt;
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(x.size()), 2);
  columns.col(0).setOnes();
  columns.col(1) = Eigen::Map<const Eigen::VectorXd>(x.data(), columns.rows());
  const Regression r = regress(columns, Eigen::Map<const Eigen::VectorXd>(y.data(), columns.rows()));
  if (r.value.size() == 0) return std::nullopt;
  return Line{r.value[0], r.error[0], r.value[1], r.error[1], r.scatter, x.size()};
}

SurveyItem slope_item(const char* place, std::string what, const Line& line, const char* unit,
                      std::string evidence, double negligible) {
  return {place,
          std::move(what),
          line.slope,
          line.slope_error,
          unit,
          std::move(evidence),
          std::abs(line.slope) > std::max(3.0 * line.slope_error, negligible)};
}

void survey_zeros(const logs::Experiment& experiment, std::vector<SurveyItem>& items) {
  const std::string path = (fs::path(experiment.directory) / "zeros.csv").string();
  std::ifstream file(path);
  if (!file) return;
  std::string line;
  std::getline(file, line);
  std::vector<double> temperature, tare[3];
  int number = 1;
  while (std::getline(file, line)) {
    ++number;
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (cells.size() < 6)
      throw Error(fmt::format("{}: line {} has {} columns, not 6", path, number, cells.size()));
    try {
      temperature.push_back(std::stod(cells[2]));
      for (std::size_t k = 0; k < 3; ++k) tare[k].push_back(std::stod(cells[3 + k]));
    } catch (const std::exception&) {
      throw Error(fmt::format("{}: line {} is not numbers", path, number));
    }
  }
  const char* names[] = {"drawbar pull", "side force", "normal load"};
  for (int k = 0; k < 3; ++k) {
    const auto n = static_cast<double>(tare[k].size());
    if (n < 4) return;
    double mean = 0.0, square = 0.0;
    for (const double v : tare[k]) mean += v / n;
    for (const double v : tare[k]) square += (v - mean) * (v - mean);
    const double deviation = std::sqrt(square / (n - 1.0));
    items.push_back({"sensor", fmt::format("zero of the {} scatters between recordings by", names[k]),
                     deviation, deviation / std::sqrt(2.0 * (n - 1.0)), "N",
                     fmt::format("{:.0f} recordings of the hanging wheel", n), deviation > 0.1});
    if (const auto fit = line_of(temperature, tare[k]))
      items.push_back(slope_item("sensor",
                                 fmt::format("zero of the {} moves with its temperature by", names[k]), *fit,
                                 "N/K", fmt::format("{:.0f} recordings", n), 0.05));
  }
}

/// Relations between the window means of the straight runs.
void survey_means(const logs::Experiment& experiment, std::vector<SurveyItem>& items) {
  std::vector<double> pull, load, pull_for_side, side, ripple, still;
  for (const logs::Run& run : experiment.runs) {
    if (!run.averages || !is_straight(run)) continue;
    const logs::Averages& a = *run.averages;
    if (a.drawbar_pull && a.normal_load) {
      pull.push_back(a.drawbar_pull->mean);
      load.push_back(a.normal_load->mean);
    }
    if (a.drawbar_pull && a.side_force) {
      pull_for_side.push_back(a.drawbar_pull->mean);
      side.push_back(a.side_force->mean);
    }
    if (a.normal_load && a.normal_load->std && a.hub_displacement && a.hub_displacement->std) {
      ripple.push_back(*a.normal_load->std);
      still.push_back(*a.hub_displacement->std);
    }
  }
  if (const auto fit = line_of(pull, load)) {
    items.push_back({"rig", "normal load at no drawbar pull (the dead weight)", fit->offset,
                     fit->offset_error, "N",
                     fmt::format("{} straight runs, scatter {:.2g} N", fit->count, fit->scatter), false});
    items.push_back(slope_item("rig", "normal load changes with the drawbar pull by", *fit, "N/N",
                               fmt::format("{} straight runs: a guide that rubs under the horizontal force, "
                                           "or a sensor tilted by {:.1f} degrees",
                                           fit->count, 57.29578 * std::atan(std::abs(fit->slope))),
                               0.01));
  }
  if (const auto fit = line_of(pull_for_side, side)) {
    items.push_back(
        {"rig", "side force at steering angle 0 and no drawbar pull", fit->offset, fit->offset_error, "N",
         fmt::format("{} straight runs, scatter {:.2g} N: tare, or steering off", fit->count, fit->scatter),
         std::abs(fit->offset) > 3.0 * fit->offset_error});
    items.push_back(slope_item(
        "sensor", "side force goes along with the drawbar pull by", *fit, "N/N",
        fmt::format("{} straight runs: sensor or wheel turned by {:.1f} degrees about the vertical",
                    fit->count, 57.29578 * std::atan(std::abs(fit->slope))),
        0.01));
  }
  if (ripple.size() >= 3) {
    double force = 0.0, height = 0.0;
    for (std::size_t i = 0; i < ripple.size(); ++i)
      force += ripple[i] / static_cast<double>(ripple.size()),
          height += still[i] / static_cast<double>(still.size());
    items.push_back(
        {"rig", "the hub stands while the normal load ripples: hub over load", height / force, 0.0, "m/N",
         fmt::format("{} windows: load {:.2g} N, hub {:.2g} mm: a slide that sticks, where a free one "
                     "would follow the soil's stiffness",
                     ripple.size(), force, 1e3 * height),
         height / force < 2e-5});
  }
  std::vector<SteadyRun> runs;
  for (std::size_t i = 0; i < experiment.runs.size(); ++i)
    if (experiment.runs[i].averages && is_straight(experiment.runs[i])) {
      try {
        runs.push_back(steady_run(experiment.runs[i], "", experiment.wheel.radius));
      } catch (const Error&) {
        continue;  // a run that cannot be used has no scatter to tell
      }
    }
  if (runs.empty()) return;
  const SteadyNoise noise = steady_noise(experiment, runs);
  for (const Channel channel :
       {Channel::drawbar_pull, Channel::side_force, Channel::normal_load, Channel::hub_displacement}) {
    const SteadyScatter& s = noise[index_of(channel)];
    if (s.pairs < 3) continue;
    const double f = shown_factor(channel);
    items.push_back({"soil", fmt::format("repeated runs differ in {} by", name_of(channel)), f * s.total(),
                     f * s.total() / std::sqrt(2.0 * s.pairs), std::string(shown_unit_of(channel)),
                     fmt::format("{} pairs of one condition; {:.2g} within a group, {:.2g} between groups",
                                 s.pairs, f * s.within, f * s.between),
                     true});
  }
}

void survey_plates(const logs::Experiment& experiment, std::vector<SurveyItem>& items) {
  const std::vector<PressCurve> curves = read_press_curves(experiment);
  if (curves.empty()) return;
  try {
    const PlateFit fit = fit_plates(curves, experiment.wheel.width);
    if (fit.compliance)
      items.push_back({"rig", "the rig gives way under load by", 1e6 * fit.compliance->value,
                       1e6 * fit.compliance->standard_error, "mm/kN", "pressed on a rigid floor",
                       fit.compliance->value > 3.0 * fit.compliance->standard_error});
    items.push_back({"soil", "pressure of equal plates differs between tests by", fit.between_tests_pressure,
                     0.0, "fraction", fmt::format("{} plate tests", fit.tests.size()), true});
    items.push_back({"soil", "exponent of the pressure-sinkage law", fit.n.value, fit.n.standard_error, "1",
                     fmt::format("{} plate tests", fit.tests.size()), true});
    if (fit.separate)
      items.push_back({"soil", "k_c: wide plates meet more pressure at equal depth when it is negative",
                       fit.k_c.value, fit.k_c.standard_error, "N/m^(n+1)",
                       fmt::format("{} plate tests", fit.tests.size()),
                       std::abs(fit.k_c.value) > 3.0 * fit.k_c.standard_error});
  } catch (const Error&) {
    return;  // plates that tell no soil tell nothing here either
  }
}

void survey_notes(const logs::Experiment& experiment, std::vector<SurveyItem>& items) {
  std::ifstream file((fs::path(experiment.directory) / "import_notes.txt").string());
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) items.push_back({"log", line, std::nan(""), 0.0, "", "noted at import", true});
}

}  // namespace

std::vector<SurveyItem> survey_logs(const logs::Experiment& experiment) {
  std::vector<SurveyItem> items;
  survey_zeros(experiment, items);
  survey_means(experiment, items);
  survey_plates(experiment, items);
  MotionSurvey motion(experiment.wheel.radius);
  for (const logs::Run& run : experiment.runs)
    if (run.bag) motion.add(run, logs::read_run_log(experiment.path_of(*run.bag)));
  motion.report(items);
  survey_notes(experiment, items);
  return items;
}

std::string survey_html(const std::vector<SurveyItem>& items) {
  std::string rows;
  for (const SurveyItem& item : items)
    rows += page::row({item.what, std::isfinite(item.value) ? fmt::format("{:.3g}", item.value) : "",
                       item.error > 0.0 ? fmt::format("± {:.2g}", item.error) : "", item.unit, item.place,
                       item.found ? "" : "within its error, or too small to matter", item.evidence});
  return "<h2>What else the logs carry</h2>" +
         page::paragraph(
             "Read off the logs without a twin: size and standard error, whether it matters or not.") +
         page::table({"What", "Size", "Error", "Unit", "Where", "", "Evidence"}, rows);
}

std::string survey_json(const std::string& experiment, const std::vector<SurveyItem>& items) {
  nlohmann::ordered_json json = {{"schema", 1}, {"experiment", experiment}};
  json["items"] = nlohmann::ordered_json::array();
  for (const SurveyItem& item : items) {
    nlohmann::ordered_json entry = {{"place", item.place}, {"what", item.what}};
    if (std::isfinite(item.value)) {
      entry["value"] = item.value;
      if (item.error > 0.0) entry["stderr"] = item.error;
      entry["unit"] = item.unit;
    }
    entry["found"] = item.found;
    entry["evidence"] = item.evidence;
    json["items"].push_back(entry);
  }
  return json.dump(1) + "\n";
}

}  // namespace wheel_twin::twin
