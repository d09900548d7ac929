// Angle of repose (paper, Section 5.2): clumps rest in a funnel over a floor, the gate opens, they heap up.
// The angle is that of a line through the mean height of the heap's surface in rings about its axis, fitted
// where the mean height lies between 20 and 80 % of the heap's height, so that neither the rounded top nor
// the scattered foot counts. SI units.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "dem/granular_soil.h"
#include "dem/measures.h"
#include "dem/system.h"

namespace wheel_twin::bulk {

struct ReposeSettings {
  std::size_t clumps = 8880;
  double opening_radius = 0.0;  ///< m; 0: eight of the largest bounding radii
  double longest_time = 12.0;   ///< s of outflow and settling; longer is an error
  std::uint64_t seed = 1;
  int threads = 1;
};

struct ReposeProfile {
  std::vector<double> radius;           ///< m, middle of the rings
  std::vector<double> height;           ///< m, mean over the ring's surface
  double angle = 0.0;                   ///< rad
  double angle_error = 0.0;             ///< rad, standard error of the fit
  double fit_from = 0.0, fit_to = 0.0;  ///< m, radii of the fitted part
  double fit_height = 0.0;              ///< m, of the line at radius 0
};

/// The fit alone: heights of the surface on a grid whose axis of the heap is at x, y.
ReposeProfile fit_repose(const dem::HeightMap& map, double x, double y, double ring_width);

struct ReposeResult {
  ReposeProfile profile;
  double angle = 0.0, angle_error = 0.0;  ///< rad
  double heap_height = 0.0;               ///< m
  std::size_t clumps = 0;
  double simulated_time = 0.0;  ///< s
  dem::HeightMap surface;
};

ReposeResult angle_of_repose(const dem::GranularSoil& soil, const ReposeSettings& settings);

/// profile.csv, angle_of_repose.svg, angle_of_repose.json in `folder`.
void write_repose_report(const std::string& folder, const dem::GranularSoil& soil,
                         const ReposeSettings& settings, const ReposeResult& result);

}  // namespace wheel_twin::bulk
