// What is refused before the work begins: settings of a bed that make no sense, and beds that do not fit into
// memory. SI units.
#pragma once

#include <string>

#include "dem/bed.h"

namespace wheel_twin::dem {

/// Throws Error, which begins with `what`, unless the value is finite, positive and at most `largest`.
void check_positive(const std::string& what, double value, double largest = 1e300);

/// Throws Error naming `what` when so many clumps, with so many spheres in all, need more memory than is
/// free (/proc/meminfo, limit of the address space).
void check_memory(const std::string& what, double clumps, double spheres);

/// Throws Error when a setting is out of range or the bed does not fit into memory.
void check_bed(const GranularSoil& soil, const BedSettings& settings);

}  // namespace wheel_twin::dem
