// A flexible wheel as ROS messages: joints, segments, and markers of the deformed wheel. Pure functions. The
// frame is the caller's, the axes are those of FlexibleWheel; SI units.
#pragma once

#include <sensor_msgs/JointState.h>
#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>
#include <wheel_twin/WheelCommand.h>
#include <wheel_twin/WheelState.h>

#include <string>

#include "wheel/flexible_wheel.h"
#include "wheel/ground.h"

namespace wheel_twin::nodes {

/// `wheel` (the hub's turning), then every rim joint `rim_00`... (rad, positive when it bends more than
/// undeformed; effort: its spring's torque, N m), then the springs `spring_00_0`... (position, set: change of
/// length, m; effort N) or the joints of the beams `beam_00_0_00`... (position, set, joint from the hub: rad,
/// N m).
sensor_msgs::JointState wheel_joints(const wheel::FlexibleWheel& wheel, const std_msgs::Header& header);

WheelState wheel_state(const wheel::FlexibleWheel& wheel, const std_msgs::Header& header);

/// Does what a command says. Throws Error naming the step when the number is not the wheel's next, the count
/// of forces does not fit, or the wheel refuses it.
void obey(wheel::FlexibleWheel& wheel, const WheelCommand& command);

/// What the colours reach their ends at; grows with what is drawn.
struct BendingScale {
  double rim = 1.0e-6;    ///< rad
  double beams = 1.0e-6;  ///< rad of a beam's joint, m of a spring
};

/// Rim plates and grousers, beams and hub: grey where unbent, red where bent more, blue where less. Springs
/// are drawn as the strips that they stand for, semicircles beside the rim. `text` stands over the wheel.
visualization_msgs::MarkerArray wheel_markers(const wheel::FlexibleWheel& wheel, BendingScale& scale,
                                              const std::string& text, const std::string& frame);

visualization_msgs::MarkerArray ground_markers(const wheel::Ground& ground, const std::string& frame);

}  // namespace wheel_twin::nodes
