// Sensors as their YAML describes them (config/sensors). SI units.
#pragma once

#include <Eigen/Core>
#include <string>

#include "base/yaml.h"

namespace wheel_twin::rig {

using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< force x, y, z (N), torque x, y, z (N m)

/// Six-axis force/torque sensor with software tare.
struct FtSettings {
  std::string name = "ft_sensor";
  double rate = 1000.0;                    ///< Hz
  Vector6 range = Vector6::Constant(1e9);  ///< of the untared signal, both signs; beyond it saturates
  Vector6 resolution = Vector6::Zero();    ///< 0: not quantised
  Vector6 noise = Vector6::Zero();         ///< standard deviation of a sample, white, after the filter
  double low_pass = 0.0;                   ///< corner of a first-order filter, Hz; 0: none
  Vector6 bias = Vector6::Zero();          ///< what the tare missed
  Vector6 drift = Vector6::Zero();         ///< per second
  double tool_weight = 0.0;                ///< N, hangs on the sensor and uses up range
};

/// Draw-wire displacement sensor with incremental encoder.
struct DrawWireSettings {
  std::string name = "draw_wire";
  double rate = 1000.0;             ///< Hz
  double range = 0.5;               ///< m of wire
  double wire_at_zero = 0.1;        ///< wire drawn out at zero displacement, m
  double resolution = 5e-5;         ///< m; 0: not quantised
  double linearity = 0.0;           ///< largest error over the range as a fraction of it
  double noise = 0.0;               ///< standard deviation, m
  double tension = 0.0;             ///< spring pulling the slide up, N
  double tension_hysteresis = 0.0;  ///< between drawing out and letting in, N: friction to the slide
  bool tension_trimmed = true;  ///< dead weights were set with the wire hooked in: its mean is made up for
};

/// Motor encoders and current.
struct JointSettings {
  std::string name = "joints";
  double rate = 100.0;                   ///< Hz
  double carriage_resolution = 0.0;      ///< m
  double wheel_resolution = 0.0;         ///< rad
  double carriage_velocity_noise = 0.0;  ///< m/s
  double wheel_rate_noise = 0.0;         ///< rad/s
  double effort_noise = 0.0;             ///< N m
  double effort_resolution = 0.0;        ///< N m
};

struct TemperatureSettings {
  std::string name = "thermometer";
  double rate = 1.0;        ///< Hz
  double noise = 0.0;       ///< K
  double resolution = 0.0;  ///< K
};

struct SensorSettings {
  FtSettings ft;
  DrawWireSettings draw_wire;
  JointSettings joints;
  TemperatureSettings temperature;
};

/// Each throws Error naming file, line and key.
FtSettings read_ft(const yaml::Map& map);
DrawWireSettings read_draw_wire(const yaml::Map& map);
JointSettings read_joints(const yaml::Map& map);
TemperatureSettings read_temperature(const yaml::Map& map);

}  // namespace wheel_twin::rig
