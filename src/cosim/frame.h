// One picture's worth of a co-simulated run as a file: where grains and wheel are and what they bear, for
// `scripts/film`. HDF5 (dem/archive.h, kind "frame"), single precision. Frame `rig`, SI units.
#pragma once

#include <string>

#include "cosim/dem_contact.h"
#include "rig/step.h"

namespace wheel_twin::cosim {

/// Arrays: spheres (x, y, z, radius, speed, force on the clump), wheel (corners of the rim's and grousers'
/// triangles), bending (rad, of each triangle's segment), springs (both ends of every piece of spring or
/// beam), force (on the hub). Numbers: time, slip, hub_x, hub_z, sinkage, drive_torque, rim_radius. Throws
/// Error naming the file.
void write_frame(const std::string& path, const DemContact& contact, const rig::RigStep& step);

}  // namespace wheel_twin::cosim
