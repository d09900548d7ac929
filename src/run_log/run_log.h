// The log of one run in memory, without ROS: what a bag of a rig holds (topics of the same content). SI
// units. Frames and signs: drawbar pull is +Fx, normal load +Fz (the soil pushes the wheel up), to the left
// +Fy; hub displacement is positive down from first touch of the undisturbed soil. Times are header stamps,
// in seconds since `epoch`, each series in the order in which it was recorded.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace wheel_twin::run_log {

struct WrenchSeries {
  std::vector<double> time;
  std::vector<Eigen::Vector3d> force;   ///< on the sensor's tool side, sensor axes, tared, N
  std::vector<Eigen::Vector3d> torque;  ///< N m
};

struct ScalarSeries {
  std::vector<double> time;
  std::vector<double> value;
};

struct JointSeries {
  std::vector<double> time;
  std::vector<double> carriage_position;  ///< m
  std::vector<double> carriage_velocity;  ///< m/s
  std::vector<double> wheel_angle;        ///< rad
  std::vector<double> wheel_rate;         ///< rad/s
  std::vector<double> wheel_effort;       ///< N m at the motor
};

struct RunLog {
  double epoch = 0.0;  ///< ROS time of time 0, s; above 0
  WrenchSeries ft;
  ScalarSeries draw_wire;  ///< m, positive down
  JointSeries joints;
  ScalarSeries temperature;  ///< degrees C; empty when not logged
};

}  // namespace wheel_twin::run_log
