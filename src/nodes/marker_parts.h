// Pieces that markers are made of. Frame `rig`, stamp 0: drawn with the newest transform.
#pragma once

#include <visualization_msgs/Marker.h>

#include <Eigen/Core>

namespace wheel_twin::nodes {

std_msgs::ColorRGBA colour(double r, double g, double b, double a = 1.0);
geometry_msgs::Point point(double x, double y, double z);
geometry_msgs::Point point(const Eigen::Vector3d& p);
/// A white marker of unit scale at the origin.
visualization_msgs::Marker marker(const char* name, int id, int type);

}  // namespace wheel_twin::nodes
