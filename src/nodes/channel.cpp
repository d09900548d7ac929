#include "nodes/channel.h"

namespace wheel_twin::nodes {

double blend(double a, double b, double share) {
  return a + (b - a) * share;
}

rig::WrenchReading blend(const rig::WrenchReading& a, const rig::WrenchReading& b, double share) {
  return {a.force + (b.force - a.force) * share, a.torque + (b.torque - a.torque) * share};
}

rig::JointReading blend(const rig::JointReading& a, const rig::JointReading& b, double share) {
  rig::JointReading mixed;
  mixed.carriage_position = blend(a.carriage_position, b.carriage_position, share);
  mixed.carriage_velocity = blend(a.carriage_velocity, b.carriage_velocity, share);
  mixed.wheel_angle = blend(a.wheel_angle, b.wheel_angle, share);
  mixed.wheel_rate = blend(a.wheel_rate, b.wheel_rate, share);
  mixed.wheel_effort = blend(a.wheel_effort, b.wheel_effort, share);
  return mixed;
}

}  // namespace wheel_twin::nodes
