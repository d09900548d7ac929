// Rebuilds a damaged bag: every message that the scan can read goes, as it was recorded, into a new bag with
// an index.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "logs/bag_scanner.h"

namespace wheel_twin::logs {

struct Salvage {
  std::string output;   ///< the new bag; empty when the bag was intact and nothing was written
  ScanSummary summary;  ///< of the damaged bag
  std::map<std::string, std::uint64_t> written;  ///< messages of each topic
  std::uint64_t time_zero =
      0;  ///< of these, recorded at bag time 0, which no reader takes: given the time of the one before
};

/// run.bag and run.bag.active give run.salvaged.bag beside it.
std::string salvaged_name(const std::string& path);

/// Writes salvaged_name(path) unless the bag is intact. Throws Error when nothing can be read, or the output
/// exists.
Salvage salvage_bag(const std::string& path);

}  // namespace wheel_twin::logs
