// The unknowns of a baseline twin: soil, hub stiffness and mount, with priors about what was declared.
// Calibrated on reference runs; where there are none, fitted together with an effect.
#pragma once

#include <vector>

#include "logs/experiment.h"
#include "twin/fit.h"
#include "twin/noise.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

/// The declared twin of an experiment.
TwinConfig declared_twin(const logs::Experiment& experiment);

/// Unknowns about `model`: logarithms of factors on stiffness, shear modulus and hub stiffness, the others
/// absolute.
std::vector<Unknown> baseline_unknowns(const TwinConfig& model);

/// `model` with the values x of `unknowns` (some or all of baseline_unknowns) replaced.
TwinConfig with_baseline(const TwinConfig& model, const std::vector<Unknown>& unknowns,
                         const std::vector<double>& x);

/// What `model` still misses of the level of each channel on `runs`, as smooth functions of slip and load;
/// only where leaving runs out shows that it foretells them.
std::vector<Correction> remaining_corrections(const TwinConfig& model,
                                              const std::vector<const RunGrid*>& runs,
                                              const std::vector<NoiseModel>& noise);

struct Calibration;

/// Those of the unknowns that leave the shape of the contact law alone, so that its table stays good, about
/// the calibrated model, with the priors about the declared one.
std::vector<Unknown> unknowns_beside_shape(const Calibration& calibration);

struct Calibration {
  TwinConfig model;
  NoiseModel noise;
  std::vector<Unknown> unknowns;
  FitResult fit;
};

/// Deviation of what a fitted contact law misses of the level of each channel on a real soil: about twice
/// what the fit tolerates; the load is what the slide carries, which no law misses.
NoiseFloor missed_by_contact_law(const std::vector<const RunGrid*>& runs);

/// Fits the baseline to `runs`, then models what is left of each channel as a smooth function of slip and
/// load (TwinConfig::corrections), then estimates the noise. `floor` as of noise_floor. Throws Error when no
/// declared soil near the prior carries the loads.
Calibration calibrate(const TwinConfig& declared, const std::vector<const RunGrid*>& runs,
                      const NoiseFloor& floor);

}  // namespace wheel_twin::twin
