// What rviz shows beside the rig itself, as markers: soil surface with the rut, trace of the hub, forces at
// the wheel, numbers as text. Pure functions of the state, without publishers. Frame `rig`, SI units; numbers
// in N, mm, N m.
#pragma once

#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "nodes/rut.h"

namespace wheel_twin::nodes {

struct BinSize {
  double length_begin = -0.2275;  ///< x of the first wall, m
  double length_end = 0.9275;
  double width = 0.76;              ///< m
  double depth = 0.13;              ///< m
  double repose_angle = 0.6981317;  ///< slope of the rut's sides, rad
};

/// The bed as a coloured surface, the rut `wheel_width` wide about y = 0, and its sides down to the floor of
/// the bin.
visualization_msgs::Marker soil_surface(const Rut& rut, const BinSize& bin, double wheel_width);

/// The path of the hub and the line of the rut's floor.
class Trace {
 public:
  void add(const Eigen::Vector3d& hub);  ///< points closer than 1 mm to the last are left out
  void clear() { points_.clear(); }
  visualization_msgs::MarkerArray markers(const Rut& rut) const;

 private:
  std::vector<Eigen::Vector3d> points_;
};

/// What the labels say. Measured and twin stand beside each other where both are known.
struct Gauges {
  std::string title;  ///< first line
  std::string phase;  ///< second line
  double time = 0.0;  ///< s
  double slip = 0.0;
  Eigen::Vector3d hub{0.0, 0.0, 0.0};  ///< m, frame rig
  double radius = 0.09;                ///< of the wheel, m
  struct Channels {
    Eigen::Vector3d force{0.0, 0.0, 0.0};  ///< on the hub, rig axes, N
    double hub_displacement = 0.0;         ///< m, positive down
    double motor_effort = 0.0;             ///< N m
  };
  Channels measured;
  bool has_twin = false;
  Channels twin;
};

visualization_msgs::MarkerArray labels(const Gauges& gauges);

}  // namespace wheel_twin::nodes
