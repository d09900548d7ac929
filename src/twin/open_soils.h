// What the reference runs leave open of soil, hub and mount: the calibrated twin and those that lie one
// standard deviation off it, along the directions in which the calibrated unknowns are least certain.
#pragma once

#include <array>
#include <vector>

#include "twin/baseline.h"

namespace wheel_twin::twin {

/// How much further from the calibrated soil than its errors tell one lies that has another form than the
/// contact law's.
constexpr double other_form = 2.0;

/// The calibrated twin first. The others step away from the bounds of the unknowns; those that cannot carry
/// `runs` are left out. All have the calibrated start and corrections, and no table.
std::vector<TwinConfig> open_soils(const TwinConfig& declared, const Calibration& calibration,
                                   const std::vector<const RunGrid*>& runs);

/// Deviation of the level of each channel that `soils` (as of open_soils) leave open in each of `runs`, when
/// each of them is corrected on `references` as a baseline is: little between reference runs, much beyond
/// their slips and loads.
std::vector<std::array<double, channel_count>> left_open(const std::vector<TwinConfig>& soils,
                                                         const std::vector<const RunGrid*>& references,
                                                         const std::vector<const RunGrid*>& runs);

}  // namespace wheel_twin::twin
