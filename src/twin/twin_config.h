// A twin: a baseline (wheel, soil, rig), effects on top of it, and an empirical correction that has no
// physical name. Adding the effect that a model lacks is adding one entry to `effects`. Written and read as
// YAML (revised_twin.yaml).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "effects/effect.h"
#include "rig/settings.h"
#include "terramechanics/contact_table.h"
#include "terramechanics/soil.h"
#include "terramechanics/wheel.h"
#include "twin/channel.h"

namespace wheel_twin::twin {

struct EffectSetting {
  std::string name;            ///< in the catalogue
  std::vector<double> values;  ///< in the order of its parameters
};

/// Smooth function of slip and load added to one channel: what the baseline's contact law misses on reference
/// runs (Kennedy and O'Hagan, 2001: model discrepancy). A sum of Gaussian bumps with the weights of a
/// Gaussian-process mean.
struct Correction {
  Channel channel = Channel::drawbar_pull;
  double slip_length = 0.3;
  double load_length = 30.0;  ///< N
  std::vector<double> slip, load, weight;

  double at(double slip_now, double load_now) const;  ///< unit of the channel
};

struct TwinConfig {
  std::string name = "twin";
  terramechanics::Wheel wheel;
  terramechanics::Soil soil;
  rig::RigSettings rig;
  double start_up = 1.0;  ///< rig::SemiEmpiricalOptions
  std::vector<EffectSetting> effects;
  std::vector<Correction> corrections;                        ///< apply while the wheel moves
  std::shared_ptr<const terramechanics::ContactTable> table;  ///< makes simulations quick; not written
};

/// Strict; throws Error naming file, line and key, effect and parameter.
TwinConfig read_twin(const std::string& path);
std::string twin_text(const TwinConfig& model);
void write_twin(const TwinConfig& model, const std::string& path);

}  // namespace wheel_twin::twin
