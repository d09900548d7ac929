// `twin import cmu_testbed`: the logs of the single-wheel testbed of the Robomechanics Lab, Carnegie Mellon
// University, to experiments in our form. One experiment a wheel; `group` is the day. doc/importing_logs.md
// says what was found in the data and what is made of it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace wheel_twin::logs::cmu {

struct ImportSummary {
  struct PerWheel {
    std::string wheel;
    std::string directory;
    std::size_t runs = 0;
    std::size_t bags = 0;  ///< runs with kinematics
    std::size_t pressings = 0;
  };
  std::vector<PerWheel> experiments;
  std::vector<std::string> remarks;  ///< anything odd, one line each
};

/// Reads `directory` (laid out as data/cmu_testbed_sample) and writes `out`/smooth and `out`/grouser, each
/// where the data set has runs of that wheel, and `out`/zeros.csv where it has recordings of the hanging
/// wheel. Kinematics, pressings and zero recordings may be missing; runs.csv may not. Throws Error naming
/// file, line and column.
ImportSummary import(const std::string& directory, const std::string& out);

}  // namespace wheel_twin::logs::cmu
