#include "twin/open_soils.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace wheel_twin::twin {
namespace {

constexpr Eigen::Index most_directions = 12;

using Levels = Eigen::Matrix<double, channel_rows, Eigen::Dynamic>;  ///< a column for each run

std::vector<double> moved(const std::vector<Unknown>& unknowns, const std::vector<double>& x,
                          const Eigen::VectorXd& step) {
  std::vector<double> result;
  for (std::size_t j = 0; j < x.size(); ++j)
    result.push_back(
        std::clamp(x[j] + step[static_cast<Eigen::Index>(j)], unknowns[j].lower, unknowns[j].upper));
  return result;
}

/// Square of what bounds take off a step, in deviations of the priors.
double taken_by_bounds(const std::vector<Unknown>& unknowns, const std::vector<double>& x,
                       const Eigen::VectorXd& step) {
  const std::vector<double> reached = moved(unknowns, x, step);
  double sum = 0.0;
  for (std::size_t j = 0; j < x.size(); ++j)
    sum +=
        std::pow((x[j] + step[static_cast<Eigen::Index>(j)] - reached[j]) / unknowns[j].prior_deviation, 2);
  return sum;
}

bool carries(const TwinConfig& model, const std::vector<const RunGrid*>& runs) {
  try {
    for (const RunGrid* run : runs) simulate(model, *run);
  } catch (const Error&) {
    return false;
  }
  return true;
}

Levels levels_of(const TwinConfig& model, const std::vector<const RunGrid*>& runs) {
  Levels levels = Levels::Zero(channel_rows, static_cast<Eigen::Index>(runs.size()));
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Predicted course = simulate(model, *runs[r]);
    double count = 0.0;
    for (int i = 0; i < runs[r]->bins(); ++i) {
      if (!runs[r]->moving[static_cast<std::size_t>(i)]) continue;
      levels.col(static_cast<Eigen::Index>(r)) += course.col(i);
      count += 1.0;
    }
    if (count > 0.0) levels.col(static_cast<Eigen::Index>(r)) /= count;
  }
  return levels;
}

/// Share of what a correction holds at each of `references` that it has at each of `runs`.
Eigen::MatrixXd seen(const std::vector<const RunGrid*>& references, const std::vector<const RunGrid*>& runs) {
  constexpr double nugget = 0.01;  // of the variance
  const auto kernel = [&](const std::vector<const RunGrid*>& at) {
    Eigen::MatrixXd k(static_cast<Eigen::Index>(at.size()), static_cast<Eigen::Index>(references.size()));
    for (std::size_t j = 0; j < references.size(); ++j) {
      Correction unit;
      unit.slip = {typical_slip(*references[j])};
      unit.load = {references[j]->declared.load};
      unit.weight = {1.0};
      for (std::size_t i = 0; i < at.size(); ++i)
        k(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            unit.at(typical_slip(*at[i]), at[i]->declared.load);
    }
    return k;
  };
  Eigen::MatrixXd among = kernel(references);
  among.diagonal().array() += nugget;
  return kernel(runs) * among.inverse();
}

}  // namespace

std::vector<TwinConfig> open_soils(const TwinConfig& declared, const Calibration& calibration,
                                   const std::vector<const RunGrid*>& runs) {
  const std::vector<Unknown>& unknowns = calibration.unknowns;
  const std::vector<double>& x = calibration.fit.x;
  const auto soil_at = [&](const std::vector<double>& values) {
    TwinConfig model = with_baseline(declared, unknowns, values);
    model.start_up = calibration.model.start_up;
    model.corrections = calibration.model.corrections;
    return model;
  };
  std::vector<TwinConfig> soils = {soil_at(x)};
  // Directions in units of the priors: how much of what was uncertain still is.
  Eigen::VectorXd prior(static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t j = 0; j < unknowns.size(); ++j)
    prior[static_cast<Eigen::Index>(j)] = unknowns[j].prior_deviation;
  const Eigen::MatrixXd share =
      prior.cwiseInverse().asDiagonal() * calibration.fit.covariance * prior.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(share);
  for (Eigen::Index k = 0; k < std::min(most_directions, share.rows()); ++k) {
    const Eigen::Index i = share.rows() - 1 - k;  // the largest first
    Eigen::VectorXd step =
        prior.cwiseProduct(solver.eigenvectors().col(i)) * std::sqrt(std::max(0.0, solver.eigenvalues()[i]));
    if (taken_by_bounds(unknowns, x, -step) < taken_by_bounds(unknowns, x, step)) step = -step;
    for (const double sign : {1.0, -1.0}) {
      TwinConfig soil = soil_at(moved(unknowns, x, sign * step));
      if (!carries(soil, runs)) continue;
      soils.push_back(std::move(soil));
      break;
    }
  }
  return soils;
}

std::vector<std::array<double, channel_count>> left_open(const std::vector<TwinConfig>& soils,
                                                         const std::vector<const RunGrid*>& references,
                                                         const std::vector<const RunGrid*>& runs) {
  const Eigen::MatrixXd share = seen(references, runs);
  const Levels at_references = levels_of(soils.front(), references), at_runs = levels_of(soils.front(), runs);
  Levels square = Levels::Zero(channel_rows, static_cast<Eigen::Index>(runs.size()));
  for (std::size_t k = 1; k < soils.size(); ++k) {
    const Levels change = levels_of(soils[k], references) - at_references;
    const Levels left = levels_of(soils[k], runs) - at_runs - change * share.transpose();
    square += left.cwiseAbs2();
  }
  std::vector<std::array<double, channel_count>> result(runs.size());
  for (std::size_t r = 0; r < runs.size(); ++r)
    for (std::size_t c = 0; c < channel_count; ++c)
      result[r][c] = std::sqrt(square(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(r)));
  return result;
}

}  // namespace wheel_twin::twin
