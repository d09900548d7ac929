// The parts of a co-simulation's checkpoint: soil on one side, wheel and the answers given so far on the
// other, together in one archive. A run taken up from it goes on with identical bits. SI units.
#pragma once

#include <string>

#include "cosim/coupled_contact.h"
#include "cosim/dem_soil.h"
#include "dem/archive.h"

namespace wheel_twin::cosim {

constexpr const char* checkpoint_kind = "co-simulation";

/// The soil's part, with what it must agree with.
dem::Archive soil_archive(const DemSoil& soil);
/// Throws Error naming `path` when it belongs to another soil or bed.
void restore_soil(const dem::Archive& archive, const std::string& path, DemSoil& soil);

/// The part of wheel and rig.
void store(const CouplingState& state, dem::Archive& archive);
/// Throws Error naming `path` when it belongs to a wheel that has not `segments` of them.
CouplingState load_coupling(const dem::Archive& archive, const std::string& path, std::size_t segments);

/// Of everything that soil and wheel must have in common: the faces of the rim (SHA-256).
std::string wheel_fingerprint(const wheel::FlexibleWheel& wheel);

}  // namespace wheel_twin::cosim
