#include "rig/mount_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace wheel_twin::rig {
namespace {

constexpr double block = 1.0;  // s

/// Mean of `value(i)` over the samples of `times` within [from, from + block); `first` moves along. NaN:
/// there is none.
template <typename Value>
double block_mean(const std::vector<double>& times, double from, std::size_t& first, const Value& value) {
  while (first < times.size() && times[first] < from) ++first;
  double sum = 0.0;
  std::size_t count = 0;
  for (; first < times.size() && times[first] < from + block; ++first, ++count) sum += value(first);
  return count > 0 ? sum / static_cast<double>(count) : std::nan("");
}

struct Row {
  Eigen::Vector3d regressors;  // of arm_x, arm_z, share
  double pitch_torque;
};

void add_rows(const run_log::RunLog& log, std::vector<Row>& rows) {
  if (log.ft.time.empty() || log.joints.wheel_effort.empty()) return;
  const double start = std::max(log.ft.time.front(), log.joints.time.front());
  const double end = std::min(log.ft.time.back(), log.joints.time.back());
  std::size_t at[4] = {0, 0, 0, 0};
  for (int i = 0; start + (i + 1) * block <= end; ++i) {
    const double from = start + i * block;
    const double fx =
        block_mean(log.ft.time, from, at[0], [&](std::size_t k) { return log.ft.force[k].x(); });
    const double fz =
        block_mean(log.ft.time, from, at[1], [&](std::size_t k) { return log.ft.force[k].z(); });
    const double my =
        block_mean(log.ft.time, from, at[2], [&](std::size_t k) { return log.ft.torque[k].y(); });
    const double effort =
        block_mean(log.joints.time, from, at[3], [&](std::size_t k) { return log.joints.wheel_effort[k]; });
    const Row row{{fz, -fx, effort}, my};
    if (row.regressors.allFinite() && std::isfinite(my)) rows.push_back(row);
  }
}

}  // namespace

MountFit fit_mount(const std::vector<const run_log::RunLog*>& logs, const MountSettings& prior) {
  MountFit fit;
  fit.mount = prior;
  std::vector<Row> rows;
  for (const run_log::RunLog* log : logs) add_rows(*log, rows);
  if (rows.empty()) return fit;

  const Eigen::Vector3d known(prior.arm_x, prior.arm_z, prior.drive_torque_share);
  const Eigen::Vector3d spread(0.3, 0.3, 1.0);
  constexpr double typical_noise = 0.01;  // N m, of an average; weighs the prior alone
  Eigen::Matrix3d normal = (typical_noise * spread.cwiseInverse()).cwiseAbs2().asDiagonal();
  Eigen::Vector3d right = normal * known;
  for (const Row& row : rows) {
    normal += row.regressors * row.regressors.transpose();
    right += row.regressors * row.pitch_torque;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
  const Eigen::Vector3d found = solver.solve(right);
  double square = 0.0;
  for (const Row& row : rows) square += std::pow(row.pitch_torque - row.regressors.dot(found), 2);
  const double count = static_cast<double>(rows.size());
  const double noise = std::max(std::sqrt(square / std::max(1.0, count - 3.0)), 1e-6);
  const Eigen::Matrix3d covariance = noise * noise * solver.solve(Eigen::Matrix3d::Identity());
  fit.mount.arm_x = found[0];
  fit.mount.arm_z = found[1];
  fit.mount.drive_torque_share = found[2];
  fit.arm_x_error = std::sqrt(covariance(0, 0));
  fit.arm_z_error = std::sqrt(covariance(1, 1));
  fit.share_error = std::sqrt(covariance(2, 2));
  fit.residual = std::sqrt(square / count);
  fit.averages = rows.size();
  return fit;
}

}  // namespace wheel_twin::rig
