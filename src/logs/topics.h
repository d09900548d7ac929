// The topics of a rig log.
#pragma once

namespace wheel_twin::logs {

inline constexpr char wrench_topic[] = "/ft_sensor/wrench";              ///< geometry_msgs/WrenchStamped
inline constexpr char displacement_topic[] = "/draw_wire/displacement";  ///< wheel_twin/DisplacementStamped
inline constexpr char joints_topic[] = "/rig/joint_states";              ///< sensor_msgs/JointState
inline constexpr char temperature_topic[] = "/rig/temperature";          ///< sensor_msgs/Temperature

}  // namespace wheel_twin::logs
