#include "logs/cmu_testbed_plates.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "logs/cmu_testbed_bag.h"
#include "logs/cmu_testbed_motion.h"
#include "run_log/interpolate.h"

namespace wheel_twin::logs::cmu {
namespace {

namespace fs = std::filesystem;

// Scatter of force about a polynomial of degree 7 in depth, the depth taken `lag` later.
double scatter(const run_log::ScalarSeries& force, const run_log::ScalarSeries& depth, double lag) {
  constexpr int terms = 8;
  const auto n = static_cast<Eigen::Index>(force.time.size());
  Eigen::VectorXd d(n);
  for (Eigen::Index i = 0; i < n; ++i)
    d[i] = run_log::value_at(depth, force.time[static_cast<std::size_t>(i)] + lag);
  const double low = d.minCoeff(), span = std::max(d.maxCoeff() - low, 1e-9);
  Eigen::MatrixXd basis(n, terms);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = 2.0 * (d[i] - low) / span - 1.0;
    basis(i, 0) = 1.0;
    basis(i, 1) = x;
    for (int k = 2; k < terms; ++k) basis(i, k) = 2.0 * x * basis(i, k - 1) - basis(i, k - 2);
  }
  const Eigen::Map<const Eigen::VectorXd> f(force.value.data(), n);
  const Eigen::VectorXd fitted = basis * basis.colPivHouseholderQr().solve(f);
  return std::sqrt((f - fitted).squaredNorm() / static_cast<double>(n));
}

std::string box_of(const std::string& name) {
  std::string box = name;
  for (const char* word : {"_smooth", "_grouser"})
    if (const auto at = box.find(word); at != std::string::npos) box.erase(at);
  while (!box.empty() && (std::isdigit(static_cast<unsigned char>(box.back())) != 0)) box.pop_back();
  while (!box.empty() && box.back() == '_') box.pop_back();
  return box.empty() ? name : box;
}

struct Raw {
  FtRecording ft;
  Motion motion;
};

Pressing pressing_of(const std::string& directory, const PlateRow& row, Raw& raw,
                     std::vector<std::string>& remarks) {
  const std::string stem = (fs::path(directory) / row.file).string();
  Pressing pressing;
  pressing.row = row;
  pressing.name = fs::path(row.file).filename().string();
  pressing.box = box_of(pressing.name);
  const Tare tare = tare_of(read_ft(stem + "_zero.bag"));
  raw.ft = read_ft(stem + ".bag");
  const Kinematics kinematics = read_kinematics(stem + ".txt", remarks);
  pressing.has_eighth_column = kinematics.has_eighth_column;
  raw.motion = to_motion(kinematics, static_cast<int>(row.clock_behind_utc_h), false);
  const double begin = raw.ft.time.front();
  if (std::abs(raw.motion.epoch - begin) > 60.0)
    throw Error(
        fmt::format("{}: the kinematics start {:.0f} s after the F/T bag: another recording, or "
                    "txt_clock_behind_utc_h is wrong",
                    stem + ".txt", raw.motion.epoch - begin));
  if (raw.ft.saturated > 0)
    remarks.push_back(
        fmt::format("{}.bag: the sensor flags {} samples as saturated", row.file, raw.ft.saturated));
  if (raw.ft.dropped > 0)
    remarks.push_back(
        fmt::format("{}.bag: {} samples left out, not finite or not in the order of their stamps", row.file,
                    raw.ft.dropped));
  const Eigen::Vector3d offset(0.0, 0.0, row.force_offset_n);
  pressing.log.epoch = std::floor(begin);
  std::size_t before = 0;
  for (std::size_t i = 0; i < raw.ft.time.size(); ++i) {
    const double since = raw.ft.time[i] - begin;
    const Eigen::Vector3d force = to_rig_axes(raw.ft.force[i] - tare.force + offset);
    if (since < 2.0) {
      pressing.weight_before += force.z();
      ++before;
    }
    if (since < row.stroke_start_s || since > row.stroke_end_s) continue;
    pressing.log.ft.time.push_back(raw.ft.time[i] - pressing.log.epoch);
    pressing.log.ft.force.push_back(force);
    pressing.log.ft.torque.push_back(to_rig_axes(raw.ft.torque[i] - tare.torque));
    pressing.log.temperature.time.push_back(raw.ft.time[i] - pressing.log.epoch);
    pressing.log.temperature.value.push_back(raw.ft.temperature[i]);
  }
  pressing.weight_before /= static_cast<double>(std::max<std::size_t>(before, 1));
  if (pressing.log.ft.time.size() < 50)
    throw Error(fmt::format("{}.bag: {} samples between t0_s and t1_s", stem, pressing.log.ft.time.size()));
  const double surface = row.z_surface_mm ? 1e-3 * *row.z_surface_mm : raw.motion.z.front();
  const double stroke_from = begin + row.stroke_start_s - 0.5, stroke_to = begin + row.stroke_end_s + 0.5;
  for (std::size_t i = 0; i < raw.motion.time.size(); ++i) {
    const double time = raw.motion.epoch + raw.motion.time[i];
    if (time < stroke_from || time > stroke_to) continue;
    pressing.log.draw_wire.time.push_back(time - pressing.log.epoch);
    pressing.log.draw_wire.value.push_back(surface - raw.motion.z[i]);
  }
  if (pressing.log.draw_wire.time.size() < 20)
    throw Error(
        fmt::format("{}.txt: {} rows between t0_s and t1_s", stem, pressing.log.draw_wire.time.size()));
  run_log::ScalarSeries load;
  load.time = pressing.log.ft.time;
  for (const auto& force : pressing.log.ft.force) load.value.push_back(force.z());
  pressing.lag = align_lag(load, pressing.log.draw_wire);
  return pressing;
}

}  // namespace

std::optional<double> align_lag(const run_log::ScalarSeries& force, const run_log::ScalarSeries& depth) {
  constexpr int steps = 30;
  double best = 0.0, best_scatter = 1e300, worst_scatter = 0.0;
  for (int k = -steps; k <= steps; ++k) {
    const double lag = 0.01 * k;
    const double value = scatter(force, depth, lag);
    worst_scatter = std::max(worst_scatter, value);
    if (value < best_scatter) {
      best_scatter = value;
      best = lag;
    }
  }
  const bool at_edge = std::abs(best) > 0.01 * (steps - 0.5);
  if (at_edge || worst_scatter < 1.2 * best_scatter) return std::nullopt;
  return best;
}

std::vector<Pressing> read_pressings(const std::string& directory, std::vector<std::string>& remarks) {
  std::vector<Pressing> pressings;
  for (const PlateRow& row : read_plates((fs::path(directory) / "plates.csv").string(), remarks)) {
    const fs::path stem = fs::path(directory) / row.file;
    std::string missing;
    for (const char* ending : {".bag", "_zero.bag", ".txt"})
      if (!fs::is_regular_file(stem.string() + ending))
        missing += (missing.empty() ? "" : ", ") + row.file + ending;
    if (!missing.empty()) {
      remarks.push_back(fmt::format("pressing left out, no file {}", missing));
      continue;
    }
    Raw raw;
    pressings.push_back(pressing_of(directory, row, raw, remarks));
  }
  const auto eighth = std::count_if(pressings.begin(), pressings.end(),
                                    [](const Pressing& p) { return p.has_eighth_column; });
  if (eighth > 0)
    remarks.push_back(
        fmt::format("kinematics of {} pressings have an eighth column, not known and not used", eighth));
  std::vector<double> lags;
  for (const Pressing& pressing : pressings)
    if (pressing.lag) lags.push_back(*pressing.lag);
  if (lags.empty()) return pressings;
  std::nth_element(lags.begin(), lags.begin() + static_cast<std::ptrdiff_t>(lags.size() / 2), lags.end());
  const double lag = lags[lags.size() / 2];
  for (Pressing& pressing : pressings)
    for (double& time : pressing.log.draw_wire.time) time -= lag;
  const auto [low, high] = std::minmax_element(lags.begin(), lags.end());
  remarks.push_back(
      fmt::format("clocks: force follows depth by {:+.0f} ms in the pressings (median of "
                  "{}, {:+.0f} to {:+.0f} ms): taken off",
                  -1e3 * lag, lags.size(), -1e3 * *high, -1e3 * *low));
  return pressings;
}

}  // namespace wheel_twin::logs::cmu
