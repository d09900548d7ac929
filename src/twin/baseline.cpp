#include "twin/baseline.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"
#include "rig/mount_fit.h"
#include "twin/fluctuation.h"

namespace wheel_twin::twin {
namespace {

constexpr int steady_bins = 7;  // of a run, for the first fit

/// What a contact law may miss of a channel: the tolerance of the fit to steady states.
NoiseModel tolerance(const std::vector<const RunGrid*>& runs) {
  double load = 1.0;
  for (const RunGrid* run : runs) load = std::max(load, run->declared.load);
  const NoiseFloor offsets = {0.005 * load, 0.005 * load, 0.005 * load, 1e-4, 0.0005 * load, 0.0003 * load};
  NoiseModel noise;
  for (std::size_t c = 0; c < noise.size(); ++c) {
    noise[c].deviation = offsets[c];
    noise[c].run_offset = offsets[c];
    noise[c].rest = offsets[c];
    noise[c].rest_offset = offsets[c];
  }
  return noise;
}

/// Mean of the residual of a channel while the run moves; NaN where it is not measured.
double moving_mean(const RunGrid& run, const Residual& residual, int channel) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < run.bins(); ++i)
    if (run.moving[static_cast<std::size_t>(i)] && std::isfinite(residual.bins(channel, i))) {
      sum += residual.bins(channel, i);
      ++count;
    }
  return count > 0 ? sum / count : std::nan("");
}

/// Standard error of such a mean.
double mean_error(const RunGrid& run, const ChannelNoise& noise) {
  const double bins = static_cast<double>(std::count(run.moving.begin(), run.moving.end(), true));
  const double independent = std::max(1.0, bins * (1.0 - noise.keep) / (1.0 + noise.keep));
  return noise.deviation / std::sqrt(independent);
}

double kernel(double slip, double load, const Correction& c) {
  const double a = slip / c.slip_length, b = load / c.load_length;
  return std::exp(-0.5 * (a * a + b * b));
}

/// What a channel is left with, as a smooth function of slip and load.
struct Remainder {
  Correction correction;    // Gaussian-process mean; without weights where the channel is not measured
  double run_offset = 0.0;  // deviation that remains between runs
  double foretold = 0.0;    // share of the levels' variance that the other runs foretell of a run
};

/// `noise` of each run; the offset that remains is at least `floor`.
Remainder remainder(int channel, const std::vector<const RunGrid*>& runs,
                    const std::vector<Residual>& residuals, const std::vector<NoiseModel>& noise,
                    double floor) {
  Remainder result;
  Correction& correction = result.correction;
  correction.channel = all_channels[static_cast<std::size_t>(channel)];
  std::vector<double> left, error;
  double own = 0.0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const double mean = moving_mean(*runs[r], residuals[r], channel);
    if (!std::isfinite(mean)) continue;
    correction.slip.push_back(typical_slip(*runs[r]));
    correction.load.push_back(runs[r]->declared.load);
    left.push_back(mean);
    error.push_back(mean_error(*runs[r], noise[r][static_cast<std::size_t>(channel)]));
    own += error.back() * error.back();
  }
  const auto n = static_cast<Eigen::Index>(left.size());
  if (n == 0) return result;
  own /= static_cast<double>(n);
  double square = 0.0;
  for (const double m : left) square += m * m / static_cast<double>(n);
  const double variance = std::max({square, floor * floor, own});
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      covariance(i, j) = variance * kernel(correction.slip[a] - correction.slip[b],
                                           correction.load[a] - correction.load[b], correction);
      if (i == j) covariance(i, j) += error[a] * error[a] + 0.01 * variance;
    }
  const Eigen::MatrixXd inverse = covariance.inverse();
  const Eigen::VectorXd alpha = inverse * Eigen::Map<const Eigen::VectorXd>(left.data(), n);
  for (Eigen::Index i = 0; i < n; ++i) correction.weight.push_back(variance * alpha[i]);
  // Leave-one-out error of the correction: (K^-1 m)_i / (K^-1)_ii.
  double loo = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) loo += std::pow(alpha[i] / inverse(i, i), 2) / static_cast<double>(n);
  result.foretold = square > 0.0 ? 1.0 - loo / square : 0.0;
  // Reference runs further apart than the kernel's length say nothing between them: half of what was left
  // remains.
  result.run_offset = std::sqrt(std::max(std::min(loo, square) * 0.25 + own, floor * floor));
  return result;
}

/// How gradually a wheel leaves its print, by the first moving seconds of the runs.
double best_start_up(const TwinConfig& model, const std::vector<const RunGrid*>& runs,
                     const NoiseModel& noise) {
  TwinConfig tried = model;
  const auto misfit = [&](double start_up) {
    tried.start_up = start_up;
    double sum = 0.0;
    for (const RunGrid* run : runs) {
      std::vector<double> whitened;
      whiten(*run, residual_of(*run, simulate(tried, *run)), noise, whitened);
      for (const double w : whitened) sum += w * w;
    }
    return sum;
  };
  double best = 0.0, least = misfit(0.0);
  const auto look = [&](double start_up) {
    const double sum = misfit(start_up);
    if (sum < least) least = sum, best = start_up;
  };
  for (const double start_up : {0.1, 0.25, 0.5, 1.0, 2.0}) look(start_up);
  for (const double factor : {1.4, 1.2, 1.1})
    for (const double start_up : {best * factor, best / factor})
      if (best > 0.0) look(start_up);
  return best;
}

}  // namespace

TwinConfig declared_twin(const logs::Experiment& experiment) {
  TwinConfig model;
  model.name = experiment.name;
  model.wheel = experiment.wheel;
  model.soil = experiment.soil;
  return model;
}

namespace {

std::vector<Unknown> soil_unknowns(const TwinConfig& m) {
  return {{"ln_stiffness", 0.0, -6.0, 6.0, 0.3, 0.0, 1.5},
          {"n", m.soil.n, 0.3, 2.0, 0.1, m.soil.n, 0.1},
          {"c", m.soil.c, 0.0, 2e4, 200.0, m.soil.c, 200.0},
          {"phi", m.soil.phi, 0.2, 1.1, 0.05, m.soil.phi, 0.12},
          {"ln_K", 0.0, -3.0, 3.0, 0.2, 0.0, 0.7},
          {"c1", m.soil.c1, 0.0, 1.0, 0.05, m.soil.c1, 0.15},
          {"c2", m.soil.c2, -0.8, 0.8, 0.05, m.soil.c2, 0.1},
          {"gamma", m.soil.gamma, 0.0, 1.0, 0.1, m.soil.gamma, 0.3}};
}

}  // namespace

std::vector<Unknown> baseline_unknowns(const TwinConfig& m) {
  std::vector<Unknown> u = soil_unknowns(m);
  const std::vector<Unknown> of_rig = {
      {"arm_z", m.rig.mount.arm_z, -1.0, 1.0, 0.02, m.rig.mount.arm_z, 0.3},
      {"drive_torque_share", m.rig.mount.drive_torque_share, -1.0, 1.0, 0.1, 0.0, 3.0},
      {"drive_loss", m.rig.drive.coulomb_loss, 0.0, 5.0, 0.02, m.rig.drive.coulomb_loss, 0.1}};
  u.insert(u.end(), of_rig.begin(), of_rig.end());
  if (m.wheel.stiffness) u.push_back({"ln_hub_stiffness", 0.0, -2.0, 2.0, 0.1, 0.0, 0.2});
  return u;
}

TwinConfig with_baseline(const TwinConfig& model, const std::vector<Unknown>& unknowns,
                         const std::vector<double>& x) {
  using Set = void (*)(TwinConfig&, double);
  static const std::map<std::string, Set> setters = {
      {"ln_stiffness",
       [](TwinConfig& m, double v) {
         m.soil.k_c *= std::exp(v);
         m.soil.k_phi *= std::exp(v);
       }},
      {"n", [](TwinConfig& m, double v) { m.soil.n = v; }},
      {"c", [](TwinConfig& m, double v) { m.soil.c = v; }},
      {"phi", [](TwinConfig& m, double v) { m.soil.phi = v; }},
      {"ln_K", [](TwinConfig& m, double v) { m.soil.K *= std::exp(v); }},
      {"c1", [](TwinConfig& m, double v) { m.soil.c1 = v; }},
      {"c2", [](TwinConfig& m, double v) { m.soil.c2 = v; }},
      {"gamma", [](TwinConfig& m, double v) { m.soil.gamma = v; }},
      {"arm_z", [](TwinConfig& m, double v) { m.rig.mount.arm_z = v; }},
      {"drive_torque_share", [](TwinConfig& m, double v) { m.rig.mount.drive_torque_share = v; }},
      {"drive_loss", [](TwinConfig& m, double v) { m.rig.drive.coulomb_loss = v; }},
      {"ln_hub_stiffness", [](TwinConfig& m, double v) { *m.wheel.stiffness *= std::exp(v); }}};
  TwinConfig m = model;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto setter = setters.find(unknowns[i].name);
    if (setter == setters.end()) throw Error("the baseline has no unknown '" + unknowns[i].name + "'");
    setter->second(m, x[i]);
  }
  return m;
}

std::vector<Unknown> unknowns_beside_shape(const Calibration& calibration) {
  std::vector<Unknown> result;
  for (std::size_t i = 0; i < calibration.unknowns.size(); ++i) {
    Unknown u = calibration.unknowns[i];
    const double found = calibration.fit.x[i];
    if (u.name == "n" || u.name == "ln_K" || u.name == "c1" || u.name == "c2" || u.name == "gamma") continue;
    u.start = found;
    if (u.name.compare(0, 3, "ln_") == 0) {  // factors on the calibrated value
      u.start = 0.0;
      u.prior -= found;
      u.lower -= found;
      u.upper -= found;
    }
    result.push_back(u);
  }
  return result;
}

std::vector<Correction> remaining_corrections(const TwinConfig& model,
                                              const std::vector<const RunGrid*>& runs,
                                              const std::vector<NoiseModel>& noise) {
  constexpr std::size_t least_runs = 4;
  constexpr double enough = 0.5;  // share of the levels' variance that must be foretold
  std::vector<Correction> found;
  if (runs.size() < least_runs) return found;
  std::vector<Residual> residuals;
  for (const RunGrid* run : runs) residuals.push_back(residual_of(*run, slow_course(model, *run)));
  for (int c = 0; c < channel_rows; ++c) {
    const Remainder left = remainder(c, runs, residuals, noise, 0.0);
    if (!left.correction.weight.empty() && left.foretold > enough) found.push_back(left.correction);
  }
  return found;
}

namespace {

/// Names of the runs in which a twin sinks to its axle.
std::string sinking_in(const TwinConfig& model, const std::vector<const RunGrid*>& runs) {
  std::string names;
  for (const RunGrid* run : runs) {
    try {
      simulate(model, *run);
    } catch (const Error&) {
      names += (names.empty() ? "" : ", ") + run->name;
    }
  }
  return names;
}

}  // namespace

NoiseFloor missed_by_contact_law(const std::vector<const RunGrid*>& runs) {
  double load = 1.0;
  for (const RunGrid* run : runs) load = std::max(load, run->declared.load);
  return {0.01 * load, 0.002 * load, 0.0, 2e-4, 0.001 * load, 0.0006 * load};
}

namespace {

/// Wrench and motor effort of a run as the log of a sensor that reads once a bin.
run_log::RunLog log_of(const RunGrid& run) {
  const auto row = [&](Channel channel, int i) {
    return run.measured(static_cast<Eigen::Index>(index_of(channel)), i);
  };
  run_log::RunLog log;
  for (int i = 0; i < run.bins(); ++i) {
    const Eigen::Vector3d force(row(Channel::drawbar_pull, i), row(Channel::side_force, i),
                                row(Channel::normal_load, i));
    const double torque = row(Channel::pitch_torque, i), effort = row(Channel::motor_effort, i);
    if (!force.allFinite() || !std::isfinite(torque) || !std::isfinite(effort)) continue;
    log.ft.time.push_back(run.time(i));
    log.ft.force.push_back(force);
    log.ft.torque.emplace_back(0.0, torque, 0.0);
    log.joints.time.push_back(run.time(i));
    log.joints.wheel_effort.push_back(effort);
  }
  return log;
}

/// Where the sensor sits and what it counts of the motor's torque the wrench tells without any soil; a soil
/// of another form than the law's would bend them after its own torque.
void know_mount(const std::vector<const RunGrid*>& runs, const rig::MountSettings& declared,
                std::vector<Unknown>& unknowns) {
  constexpr double least_arm_error = 1e-3, least_share_error = 5e-3;  // m, 1
  std::vector<run_log::RunLog> logs;
  for (const RunGrid* run : runs) logs.push_back(log_of(*run));
  std::vector<const run_log::RunLog*> pointers;
  for (const run_log::RunLog& log : logs) pointers.push_back(&log);
  const rig::MountFit fit = rig::fit_mount(pointers, declared);
  if (fit.averages == 0) return;
  const auto know = [&](const char* name, double value, double error) {
    for (Unknown& u : unknowns)
      if (u.name == name) {
        u.prior = u.start = std::clamp(value, u.lower, u.upper);
        u.prior_deviation = std::min(u.prior_deviation, error);
      }
  };
  know("arm_z", fit.mount.arm_z, std::max(least_arm_error, fit.arm_z_error));
  know("drive_torque_share", fit.mount.drive_torque_share, std::max(least_share_error, fit.share_error));
}

}  // namespace

Calibration calibrate(const TwinConfig& declared, const std::vector<const RunGrid*>& runs,
                      const NoiseFloor& floor) {
  Calibration calibration;
  calibration.unknowns = baseline_unknowns(declared);
  // Without reference runs an effect of the sensor would be taken for its place.
  if (!runs.empty() && runs.front()->declared.role == logs::Role::reference)
    know_mount(runs, declared.rig.mount, calibration.unknowns);
  const NoiseModel first = tolerance(runs);
  std::vector<RunGrid> steady;
  for (const RunGrid* run : runs) steady.push_back(condensed(*run, steady_bins));
  const ResidualFunction function = [&](const std::vector<double>& x, std::vector<double>& out) {
    try {
      const TwinConfig model = with_baseline(declared, calibration.unknowns, x);
      for (const RunGrid& run : steady) whiten(run, residual_of(run, simulate(model, run)), first, out);
    } catch (const Error&) {
      return false;
    }
    return true;
  };
  calibration.fit = least_squares(calibration.unknowns, function, 60);
  if (!calibration.fit.usable)
    throw Error(declared.name + ": no soil near the declared one carries the loads of the runs");
  // The few bins that were fitted can be carried by a soil that lets the wheel sink between them: then one
  // nearer to the declared one.
  const std::vector<double> fitted = calibration.fit.x;
  const std::size_t soil_count = soil_unknowns(declared).size();  // they come first
  std::string sinking;
  for (const double share : {1.0, 0.75, 0.5, 0.25}) {
    for (std::size_t i = 0; i < soil_count; ++i) {
      const double start = calibration.unknowns[i].start;
      calibration.fit.x[i] = start + share * (fitted[i] - start);
    }
    calibration.model = with_baseline(declared, calibration.unknowns, calibration.fit.x);
    sinking = sinking_in(calibration.model, runs);
    if (sinking.empty()) break;
  }
  if (!sinking.empty())
    throw Error(fmt::format(
        "{}: the soil fitted to the runs lets the wheel sink to its axle in {}, where it was measured above",
        declared.name, sinking));
  calibration.model.start_up = best_start_up(calibration.model, runs, first);

  std::vector<Residual> residuals;
  for (const RunGrid* run : runs) residuals.push_back(residual_of(*run, simulate(calibration.model, *run)));
  calibration.noise = estimate_noise(runs, residuals, floor);
  const std::vector<NoiseModel> noise = noise_by_run(calibration.noise, runs, residuals, floor, runs);
  for (int c = 0; c < channel_rows; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const Remainder left = remainder(c, runs, residuals, noise, 0.5 * floor[k]);
    if (left.correction.weight.empty()) continue;
    calibration.noise[k].run_offset = left.run_offset;
    calibration.model.corrections.push_back(left.correction);
  }
  return calibration;
}

}  // namespace wheel_twin::twin
