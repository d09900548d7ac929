// Pressure-sinkage test: circular plates pressed into a settled bed at constant speed; pressure is the
// vertical reaction over the plate's area. Bekker's p = (k_c / b + k_phi) z^n with b the plate's radius is
// fitted to all plates at once (least squares of log p, n common, between a tenth of the largest sinkage and
// the largest). Frame: z up, 0 at the undisturbed surface. SI units.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "dem/bed.h"

namespace wheel_twin::bulk {

struct SinkageSettings {
  std::vector<double> diameters{0.06, 0.08, 0.10};  ///< m
  double rate = 0.02;                               ///< m/s
  double sinkage = 0.02;                            ///< m, largest
  double bed_size = 0.22;                           ///< m, length and width, periodic
  double bed_depth = 0.10;                          ///< m
  std::uint64_t seed = 1;
  int threads = 1;
};

struct SinkageCurve {
  double diameter = 0.0;         ///< m
  std::vector<double> sinkage;   ///< m
  std::vector<double> pressure;  ///< Pa
};

struct SinkageResult {
  std::vector<SinkageCurve> curves;
  double n = 0.0;
  double k_c = 0.0;    ///< N/m^(n+1); 0 with a single plate
  double k_phi = 0.0;  ///< N/m^(n+2)
};

/// The fit alone. Throws Error when there is nothing to fit.
SinkageResult fit_bekker(std::vector<SinkageCurve> curves);

SinkageResult plate_sinkage(const dem::GranularSoil& soil, const SinkageSettings& settings);

/// curves.csv, plate_sinkage.svg, plate_sinkage.json in `folder`.
void write_sinkage_report(const std::string& folder, const dem::GranularSoil& soil,
                          const SinkageSettings& settings, const SinkageResult& result);

}  // namespace wheel_twin::bulk
