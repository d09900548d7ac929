#include "twin/soil_doubt.h"

#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "effects/catalogue.h"
#include "twin/open_soils.h"

namespace wheel_twin::twin {
SoilDoubt::SoilDoubt(std::vector<TwinConfig> soils, const Evidence& evidence)
    : evidence_(evidence), soils_(std::move(soils)) {
  for (const TwinConfig& soil : soils_) undisturbed_.push_back(residuals(soil));
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
  if (here.size() == 0 || left.size() != here.size() || undisturbed_.front().size() == 0) return;
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(here.size(), static_cast<Eigen::Index>(soils_.size()) - 1);
  for (std::size_t k = 1; k < soils_.size(); ++k) {
    const Eigen::VectorXd there = with_effects(soils_[k]);
    if (there.size() == 0 || undisturbed_[k].size() == 0) continue;
    // What the change of soil does without the effect the reference runs have seen, and corrected.
    change.col(static_cast<Eigen::Index>(k) - 1) = there - here - (undisturbed_[k] - undisturbed_.front());
  }
  candidate.doubt.information = other_form * other_form * change.transpose() * change;
  candidate.doubt.slope = other_form * change.transpose() * left;

  // Information on the parameters, and how much of it the soil takes.
  const bool by_fluctuation = candidate.fluctuates && sticks(candidate.model);  // nothing else tells friction
  const Eigen::VectorXd before = by_fluctuation ? left : residuals(candidate.model);
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
      const Eigen::VectorXd there = residuals(near, by_fluctuation);
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
