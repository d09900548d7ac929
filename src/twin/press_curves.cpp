#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

#include "base/error.h"
#include "logs/bag_reader.h"
#include "run_log/interpolate.h"
#include "twin/plate_fit.h"

namespace wheel_twin::twin {
namespace {

void read_bag(const std::string& path, PressCurve& curve) {
  const run_log::RunLog log = logs::read_run_log(path);
  if (log.ft.time.empty() || log.draw_wire.time.empty())
    throw Error(fmt::format("{}: a pressing needs both wrench and displacement", path));
  for (std::size_t i = 0; i < log.ft.time.size(); ++i) {
    if (log.ft.time[i] < log.draw_wire.time.front() || log.ft.time[i] > log.draw_wire.time.back()) continue;
    curve.depth.push_back(run_log::value_at(log.draw_wire, log.ft.time[i]));
    curve.force.push_back(log.ft.force[i].z());
  }
}

void read_csv(const std::string& path, PressCurve& curve) {
  std::ifstream stream(path);
  std::string line;
  if (!std::getline(stream, line) || line.rfind("time_s,depth_m,force_n", 0) != 0)
    throw Error(fmt::format("{}:1: the header time_s,depth_m,force_n is expected", path));
  for (int number = 2; std::getline(stream, line); ++number) {
    if (line.empty() || line == "\r") continue;
    std::istringstream fields(line);
    fields.imbue(std::locale::classic());
    double time = 0.0, depth = 0.0, force = 0.0;
    char first = 0, second = 0;
    if (!(fields >> time >> first >> depth >> second >> force) || first != ',' || second != ',')
      throw Error(fmt::format("{}:{}: three numbers are expected, not '{}'", path, number, line));
    curve.depth.push_back(depth);
    curve.force.push_back(force);
  }
}

// From the start to the largest force: what follows is unloading.
void keep_loading(PressCurve& curve) {
  const auto peak = std::max_element(curve.force.begin(), curve.force.end()) - curve.force.begin() + 1;
  curve.force.resize(static_cast<std::size_t>(peak));
  curve.depth.resize(static_cast<std::size_t>(peak));
}

}  // namespace

std::vector<PressCurve> read_press_curves(const logs::Experiment& experiment) {
  std::vector<PressCurve> curves;
  for (const logs::PlateTest& test : experiment.plate_tests) {
    PressCurve curve;
    curve.name = test.bag ? *test.bag : *test.csv;
    curve.group = test.group;
    curve.indenter = test.indenter;
    if (test.diameter) curve.diameter = *test.diameter;
    if (test.width) curve.diameter = std::min(*test.width, *test.length);
    const std::string path = experiment.path_of(curve.name);
    if (test.bag)
      read_bag(path, curve);
    else
      read_csv(path, curve);
    if (curve.force.size() < 10)
      throw Error(fmt::format("{}: {} points are too few for a pressing", path, curve.force.size()));
    keep_loading(curve);
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace wheel_twin::twin
