// A granular system as files for ParaView: spheres with radius, speed, force; walls as triangles.
#pragma once

#include <string>

#include "dem/system.h"

namespace wheel_twin::dem {

/// Fields: radius (m), velocity (m/s), force (N, of the contacts on the whole clump), clump (number), shape.
void write_spheres_vtp(const std::string& path, const System& system);

}  // namespace wheel_twin::dem
