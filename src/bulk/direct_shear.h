// Virtual direct shear test (paper, Section 5.2): a box of two frames, periodic across the shear direction;
// the sample is consolidated under a servo-controlled top plate, then the lower frame moves along +x. Shear
// stress is the reaction of the soil on the lower frame over the corrected area (length - displacement) *
// width; the servo holds the normal stress of the plate on that same area. Frame: x along shear, y across, z
// up, floor of the box at 0. SI units.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bulk/line_fit.h"
#include "dem/granular_soil.h"
#include "dem/system.h"

namespace wheel_twin::bulk {

struct ShearSettings {
  double length = 0.16, width = 0.08, height = 0.04;  ///< of the box, m; the frames meet at half height
  double gap = 0.003;                                 ///< m between the frames, from the first filling on
  double consolidation_time = 0.4;                    ///< s
  double rate = 0.005;                                ///< m/s, of the lower frame
  double travel = 0.0175;                             ///< m: 3.5 s at the paper's rate
  std::vector<double> normal_stresses{20e3, 30e3, 40e3, 50e3, 70e3};  ///< Pa
  double smoothing = 0.00025;  ///< m of travel over which stresses are averaged
  std::uint64_t seed = 1;
  int threads = 1;
};

/// The settled sample, before the plate touches it.
struct ShearSample {
  dem::State state;
  std::size_t clumps = 0;
  double fill_friction = 0.0;
  double void_ratio = 0.0;  ///< pores over grains in the box, under the plate at 20 kPa
};

/// Fetched from the cache or made. The friction while filling is tuned to the soil's shear_box_void_ratio;
/// when the sample is denser than that even at full friction, it is filled at full friction: as close as
/// possible, as the paper.
ShearSample shear_sample(const dem::GranularSoil& soil, const ShearSettings& settings);

struct ShearCurve {
  double normal_stress = 0.0;        ///< wanted, Pa
  std::vector<double> travel;        ///< m
  std::vector<double> shear_stress;  ///< Pa
  std::vector<double> plate_stress;  ///< Pa, measured on the plate over the corrected area
  std::vector<double> plate_rise;    ///< m since the start of shearing: dilation
  double void_ratio_consolidated = 0.0;
  double peak_shear_stress = 0.0;   ///< Pa, largest of the averaged curve
  double final_shear_stress = 0.0;  ///< Pa, mean over the last fifth of the travel
};

/// One test. `progress` gets the fraction done.
ShearCurve shear(const dem::GranularSoil& soil, const ShearSample& sample, const ShearSettings& settings,
                 double normal_stress, const std::function<void(double)>& progress = {});

struct ShearResult {
  ShearSample sample;
  std::vector<ShearCurve> curves;
  LineFit failure_line;                                       ///< peak shear stress against normal stress, Pa
  double cohesion() const { return failure_line.intercept; }  ///< Pa
  double friction_angle() const;                              ///< rad
  double friction_angle_error() const;                        ///< rad, standard error
};

ShearResult direct_shear(const dem::GranularSoil& soil, const ShearSettings& settings);

/// curves.csv, direct_shear.svg and direct_shear.json in `folder`, which is made when missing.
void write_shear_report(const std::string& folder, const dem::GranularSoil& soil,
                        const ShearSettings& settings, const ShearResult& result);

}  // namespace wheel_twin::bulk
