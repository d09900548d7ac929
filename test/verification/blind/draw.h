// Experiments for the blind test of the diagnosis: drawn at random, wheel, soil, loads, noise and what is
// wrong with the rig. The soil that is simulated has a model form that the twin does not have.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/random.h"
#include "rig/free_run.h"
#include "terramechanics/soil.h"
#include "terramechanics/wheel.h"
#include "twin/twin_config.h"

namespace wheel_twin::blind {

/// Where the simulated soil departs from the twin's, beside its parameters.
struct ModelForm {
  std::string name;
  double size = 0.0;
};

struct Drawn {
  terramechanics::Wheel wheel;
  terramechanics::Soil soil, declared;
  rig::RunSettings run;  ///< but for slip, role and seed
  std::vector<double> slips;
  std::vector<double> reference_slips;
  double unevenness = 0.05;           ///< deviation of the log-stiffness along the travel
  double correlation_length = 0.008;  ///< of it, m
  std::vector<ModelForm> forms;
  std::vector<twin::EffectSetting> effects;  ///< in the catalogue
  std::string outside;                       ///< a cause outside it; empty: none
  double outside_size = 0.0;
};

/// The experiment of one seed.
Drawn draw(std::uint64_t seed);

/// Simulates one run. With `hidden` the effects and the cause outside the catalogue act. `even` leaves out
/// what is random.
run_log::RunLog simulate_run(const Drawn& drawn, double slip, bool hidden, std::uint64_t seed, bool even);

}  // namespace wheel_twin::blind
