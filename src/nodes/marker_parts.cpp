#include "nodes/marker_parts.h"

namespace wheel_twin::nodes {

std_msgs::ColorRGBA colour(double r, double g, double b, double a) {
  std_msgs::ColorRGBA c;
  c.r = static_cast<float>(r);
  c.g = static_cast<float>(g);
  c.b = static_cast<float>(b);
  c.a = static_cast<float>(a);
  return c;
}

geometry_msgs::Point point(double x, double y, double z) {
  geometry_msgs::Point p;
  p.x = x;
  p.y = y;
  p.z = z;
  return p;
}

geometry_msgs::Point point(const Eigen::Vector3d& p) {
  return point(p.x(), p.y(), p.z());
}

visualization_msgs::Marker marker(const char* name, int id, int type) {
  visualization_msgs::Marker m;
  m.header.frame_id = "rig";
  m.ns = name;
  m.id = id;
  m.type = type;
  m.action = visualization_msgs::Marker::ADD;
  m.pose.orientation.w = 1.0;
  m.scale.x = m.scale.y = m.scale.z = 1.0;
  m.color = colour(1, 1, 1);
  return m;
}

}  // namespace wheel_twin::nodes
