// What the reference runs leave open of soil, hub and mount, in the judgement of effects. The twin is held
// fixed while effects compete; where the soil is off, an effect acts on another soil and shows differently.
// To first order in the directions of open_soils (residual r, its change D by one standard deviation of
// each), what a candidate leaves has the covariance 1 + D D^T.
#pragma once

#include <vector>

#include "twin/candidates.h"

namespace wheel_twin::twin {

class SoilDoubt {
 public:
  /// `soils` as of open_soils; `evidence` must outlive this.
  SoilDoubt(std::vector<TwinConfig> soils, const Evidence& evidence);

  /// Sets Candidate::doubt and widens the standard errors of its parameters by it.
  void add_to(Candidate& candidate) const;

 private:
  /// Whitened residuals of all runs; empty when the twin cannot carry them.
  Eigen::VectorXd residuals(const TwinConfig& model, bool with_fluctuation = false) const;

  const Evidence& evidence_;
  std::vector<TwinConfig> soils_;             // the calibrated one, then one step along each direction
  std::vector<Eigen::VectorXd> undisturbed_;  // residuals of each without effects
};

}  // namespace wheel_twin::twin
