// How a wheel is co-simulated with a discrete-element bed: the bed, the grains' size, the time step and the
// course of the run, as a file in config/dem says. SI units.
#pragma once

#include <optional>
#include <string>

#include "base/yaml.h"
#include "cosim/dem_soil.h"
#include "dem/bed.h"
#include "dem/granular_soil.h"
#include "rig/profile.h"

namespace wheel_twin::cosim {

struct DemSettings {
  std::string name = "paper";
  dem::BedSettings bed;
  double grain_scale = 1.0;             ///< factor on the size of all grains; 1: the soil's own
  std::optional<double> step_fraction;  ///< of the Rayleigh time; none: the soil's
  double start_x = 0.12;                ///< place of the hub in the bed at the start, m
  double headroom = 0.3;                ///< of the domain above the bed, m
  dem::SleepSettings sleep;             ///< of the bed's still parts
  std::optional<BedWindow> window;      ///< of the bed that moves; none: the whole bed
  rig::RunProfile profile;  ///< course of a run; its clearance is replaced by the bed's own first touch
};

/// Keys: name, bed {length, width, depth, periodic, fill_friction (optional)}, grain_scale, step_fraction
/// (optional), start_x, headroom, sleep {speed, force, time} (optional: without it nothing sleeps),
/// window {behind, ahead} (optional), profile {lowering_speed, dwell, ramp, duration, rest}. Throws Error
/// naming file, line and key.
DemSettings read_dem_settings(const yaml::Map& map);

/// A file in config/dem, by name or path.
DemSettings load_dem_settings(const std::string& name);

/// The soil with what the settings change of it.
dem::GranularSoil scaled_soil(dem::GranularSoil soil, const DemSettings& settings);

}  // namespace wheel_twin::cosim
