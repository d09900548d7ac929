#include "twin/soil_doubt.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "effects/catalogue.h"

namespace wheel_twin::twin {
namespace {

constexpr Eigen::Index most_directions = 12;

std::vector<double> moved(const std::vector<Unknown>& unknowns, const std::vector<double>& x,
                          const Eigen::VectorXd& step) {
  std::vector<double> result;
  for (std::size_t j = 0; j < x.size(); ++j)
    result.push_back(
        std::clamp(x[j] + step[static_cast<Eigen::Index>(j)], unknowns[j].lower, unknowns[j].upper));
  return result;
}

}  // namespace

SoilDoubt::SoilDoubt(const TwinConfig& declared, const Calibration& calibration, const Evidence& evidence)
    : evidence_(evidence) {
  const std::vector<Unknown>& unknowns = calibration.unknowns;
  const std::vector<double>& x = calibration.fit.x;
  const auto soil_at = [&](const std::vector<double>& values) {
    TwinConfig model = with_baseline(declared, unknowns, values);
    model.start_up = calibration.model.start_up;
    model.corrections = calibration.model.corrections;
    return model;
  };
  const auto add = [&](const TwinConfig& model) {
    Eigen::VectorXd undisturbed = residuals(model);
    if (undisturbed.size() == 0) return false;
    soils_.push_back(model);
    undisturbed_.push_back(std::move(undisturbed));
    return true;
  };
  if (!add(soil_at(x))) return;
  // Directions in units of the priors: how much of what was uncertain still is.
  Eigen::VectorXd prior(static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t j = 0; j < unknowns.size(); ++j)
    prior[static_cast<Eigen::Index>(j)] = unknowns[j].prior_deviation;
  const Eigen::MatrixXd share =
      prior.cwiseInverse().asDiagonal() * calibration.fit.covariance * prior.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(share);
  for (Eigen::Index k = 0; k < std::min(most_directions, share.rows()); ++k) {
    const Eigen::Index i = share.rows() - 1 - k;  // the largest first
    const Eigen::VectorXd step =
        prior.cwiseProduct(solver.eigenvectors().col(i)) * std::sqrt(std::max(0.0, solver.eigenvalues()[i]));
    if (!add(soil_at(moved(unknowns, x, step)))) add(soil_at(moved(unknowns, x, -step)));
  }
}

Eigen::VectorXd SoilDoubt::residuals(const TwinConfig& model, bool with_fluctuation) const {
  std::vector<double> all;
  try {
    for (std::size_t r = 0; r < evidence_.runs.size(); ++r) {
      const std::vector<double> one = run_residuals(evidence_, r, model, with_fluctuation);
      all.insert(all.end(), one.begin(), one.end());
    }
  } catch (const Error&) {
    return {};
  }
  return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

void SoilDoubt::add_to(Candidate& candidate) const {
  if (soils_.size() < 2 || candidate.effects.empty()) return;
  const auto with_effects = [&](TwinConfig soil) {
    soil.effects = candidate.model.effects;
    return residuals(soil);
  };
  const Eigen::VectorXd here = with_effects(soils_.front());
  // The residuals that the candidate's chi-square is of, or more could be taken off it than it is.
  const Eigen::VectorXd left = candidate.fluctuates ? residuals(candidate.model, true) : here;
  if (here.size() == 0 || left.size() != here.size()) return;
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(here.size(), static_cast<Eigen::Index>(soils_.size()) - 1);
  for (std::size_t k = 1; k < soils_.size(); ++k) {
    const Eigen::VectorXd there = with_effects(soils_[k]);
    if (there.size() == 0) continue;
    // What the change of soil does without the effect the reference runs have seen, and corrected.
    change.col(static_cast<Eigen::Index>(k) - 1) = there - here - (undisturbed_[k] - undisturbed_.front());
  }
  candidate.doubt.information = change.transpose() * change;
  candidate.doubt.slope = change.transpose() * left;

  // Information on the parameters, and how much of it the soil takes.
  Eigen::MatrixXd slopes(here.size(), candidate.parameters);
  Eigen::Index at = 0;
  for (std::size_t e = 0; e < candidate.effects.size(); ++e) {
    const effects::EffectType& type = effects::find_effect(candidate.effects[e]);
    for (std::size_t i = 0; i < type.parameters.size(); ++i, ++at) {
      constexpr double difference = 0.02;  // of the scale
      const effects::Parameter& p = type.parameters[i];
      TwinConfig near = candidate.model;
      double& value = near.effects[e].values[i];
      const double step = (value + difference * p.scale > p.upper ? -1.0 : 1.0) * difference * p.scale;
      value += step;
      const Eigen::VectorXd before = residuals(candidate.model), there = residuals(near);
      slopes.col(at).setZero();
      if (there.size() == before.size()) slopes.col(at) = (there - before) / step;
    }
  }
  // p moves by -(J^T J)^-1 J^T D for a step of the soil along each direction.
  const Eigen::MatrixXd moves = slopes.completeOrthogonalDecomposition().solve(change);
  at = 0;
  for (auto& errors : candidate.errors)
    for (double& error : errors) error = std::hypot(error, moves.row(at++).norm());
}

}  // namespace wheel_twin::twin
