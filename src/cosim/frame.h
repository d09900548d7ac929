// One picture's worth of a co-simulated run as a file: where grains and wheel are and what they bear, for
// `scripts/film`. HDF5 (dem/archive.h, kind "frame"), single precision. Frame `rig`, SI units.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cosim/dem_contact.h"
#include "dem/system.h"
#include "rig/step.h"

namespace wheel_twin::cosim {

/// The spheres moved by `offset`; with `period` above 0 each by as many periods along x as bring it next to
/// `x`.
std::vector<dem::SphereState> spheres_about(std::vector<dem::SphereState> spheres,
                                            const Eigen::Vector3d& offset, double x, double period);

/// Arrays: spheres (x, y, z, radius, speed, force on the clump), wheel (corners of the rim's and grousers'
/// triangles), bending (rad, of each triangle's segment), springs (both ends of every piece of spring or
/// beam), force (on the hub). Numbers: time, slip, hub_x, hub_z, sinkage, drive_torque, rim_radius. Throws
/// Error naming the file.
void write_frame(const std::string& path, const DemContact& contact, const rig::RigStep& step);

}  // namespace wheel_twin::cosim
