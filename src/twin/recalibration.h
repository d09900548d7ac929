// Without reference runs the soil is fitted to the measured runs with nothing acting, and its whole form
// bends after what acts; an effect fitted on top of it finds part of its work done. Here the soil is fitted
// once more, to the runs less what a candidate does to them, and the candidate once more on that soil.
#pragma once

#include "twin/baseline.h"
#include "twin/candidates.h"

namespace wheel_twin::twin {

class Recalibration {
 public:
  /// `evidence` must outlive this and have nuisance.
  Recalibration(const TwinConfig& declared, const NoiseFloor& floor, const Evidence& evidence);

  /// `candidate` fitted on its own soil (Candidate::own) where that leaves less of all runs, else as it was.
  Candidate operator()(const Candidate& candidate) const;

 private:
  TwinConfig declared_;
  NoiseFloor floor_;
  const Evidence& evidence_;
};

}  // namespace wheel_twin::twin
