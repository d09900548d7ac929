// A granular soil as ROS messages: spheres as a point cloud with speed and force, the surface as an organised
// cloud, the rut as a line. Pure functions. Frame and stamp are the caller's.
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>
#include <visualization_msgs/Marker.h>

#include <vector>

#include "dem/measures.h"
#include "dem/system.h"

namespace wheel_twin::nodes {

/// One point a sphere, where `spheres` (those of `system`, moved) are, FLOAT32 fields x, y, z (m), radius
/// (m), speed (m/s, of the sphere's centre), force (N, magnitude of the contact force on its clump).
sensor_msgs::PointCloud2 soil_cloud(const dem::System& system, const std::vector<dem::SphereState>& spheres,
                                    const std_msgs::Header& header);

/// Organised cloud (width along x, height along y): x, y, z of the surface; NaN where there is no soil.
sensor_msgs::PointCloud2 height_cloud(const dem::HeightMap& map, const std_msgs::Header& header);

/// Line along x through the mean surface height of the rows within `half_width` (m) of y = 0.
visualization_msgs::Marker rut_profile(const dem::HeightMap& map, double half_width,
                                       const std_msgs::Header& header);

}  // namespace wheel_twin::nodes
