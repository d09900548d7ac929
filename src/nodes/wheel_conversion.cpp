#include "nodes/wheel_conversion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "nodes/marker_parts.h"

namespace wheel_twin::nodes {
namespace {

using Eigen::Vector3d;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;
using wheel::BeamState;
using wheel::FlexibleWheel;
using wheel::Suspension;

constexpr double kStripWidth = 0.013;  // m, of the strips that springs are drawn as

geometry_msgs::Vector3 vector(const Vector3d& v) {
  geometry_msgs::Vector3 m;
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
  return m;
}
Vector3d from(const geometry_msgs::Vector3& m) {
  return {m.x, m.y, m.z};
}

/// -1 blue, 0 grey, 1 red.
std_msgs::ColorRGBA bending_colour(double value) {
  const double v = std::clamp(value, -1.0, 1.0), grey = 0.78;
  const double fade = std::abs(v);
  return v > 0.0 ? colour(grey + (0.84 - grey) * fade, grey * (1.0 - 0.85 * fade), grey * (1.0 - 0.8 * fade))
                 : colour(grey * (1.0 - 0.85 * fade), grey * (1.0 - 0.45 * fade), grey + (0.9 - grey) * fade);
}

void triangle(Marker& m, const Vector3d& a, const Vector3d& b, const Vector3d& c,
              const std_msgs::ColorRGBA& paint) {
  for (const Vector3d& p : {a, b, c}) {
    m.points.push_back(point(p));
    m.colors.push_back(paint);
  }
}

/// Both sides, so that it is seen from wherever one looks.
void quad(Marker& m, const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
          const std_msgs::ColorRGBA& paint) {
  triangle(m, a, b, c, paint);
  triangle(m, a, c, d, paint);
  triangle(m, a, c, b, paint);
  triangle(m, a, d, c, paint);
}

void add_box(Marker& m, const wheel::SegmentState& s, const wheel::Box& box,
             const std_msgs::ColorRGBA& paint) {
  Vector3d corner[8];
  for (int i = 0; i < 8; ++i) {
    const Vector3d side((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0);
    corner[i] = s.position + s.orientation * (box.centre + side.cwiseProduct(box.half_extents));
  }
  quad(m, corner[4], corner[5], corner[7], corner[6], paint);
  quad(m, corner[0], corner[1], corner[3], corner[2], paint);
  quad(m, corner[0], corner[1], corner[5], corner[4], paint);
  quad(m, corner[2], corner[3], corner[7], corner[6], paint);
  quad(m, corner[0], corner[2], corner[6], corner[4], paint);
  quad(m, corner[1], corner[3], corner[7], corner[5], paint);
}

/// A band along a line, `across` its half width.
void add_band(Marker& m, const std::vector<Vector3d>& line, const Vector3d& across,
              const std::vector<std_msgs::ColorRGBA>& paint) {
  for (std::size_t k = 1; k < line.size(); ++k)
    quad(m, line[k - 1] - across, line[k] - across, line[k] + across, line[k - 1] + across, paint[k - 1]);
}

/// The strip of a spring: an arc of constant length from hub to rim that bulges out beside the wheel.
std::vector<Vector3d> strip(const Vector3d& hub_end, const Vector3d& rim_end, const Vector3d& outside,
                            double length) {
  const Vector3d chord = rim_end - hub_end;
  const double ratio = std::clamp(chord.norm() / length, 0.05, 0.999);
  double low = 1.0e-3, high = 3.0;  // half angle f of the arc: sin(f) / f = ratio
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (std::sin(middle) / middle > ratio ? low : high) = middle;
  }
  const double radius = 0.5 * length / low;
  const Vector3d along = chord.normalized();
  std::vector<Vector3d> line;
  for (int k = 0; k <= 12; ++k) {
    const double a = low * (k / 6.0 - 1.0);
    line.push_back(0.5 * (hub_end + rim_end) + radius * std::sin(a) * along +
                   radius * (std::cos(a) - std::cos(low)) * outside);
  }
  return line;
}

std::vector<BeamState> scaled_beams(const FlexibleWheel& wheel, BendingScale& scale) {
  std::vector<BeamState> beams = wheel.beams();
  for (const BeamState& beam : beams)
    for (const double b : beam.bending) scale.beams = std::max(scale.beams, std::abs(b));
  return beams;
}

Marker beams_marker(const FlexibleWheel& wheel, BendingScale& scale) {
  Marker m = marker("beams", 0, Marker::TRIANGLE_LIST);
  const wheel::WheelModel& model = wheel.model();
  const wheel::HubMotion hub = wheel.hub();
  const Vector3d axle{-std::sin(hub.steering), std::cos(hub.steering), 0.0};
  for (const BeamState& beam : scaled_beams(wheel, scale)) {
    if (model.suspension == Suspension::beams) {
      std::vector<std_msgs::ColorRGBA> paint;
      for (std::size_t k = 1; k < beam.points.size(); ++k)
        paint.push_back(bending_colour(0.5 * (beam.bending[k - 1] + beam.bending[k]) / scale.beams));
      add_band(m, beam.points, 0.45 * model.beams.sheet.width * axle, paint);
      continue;
    }
    const double side = (beam.points.front() - hub.position).dot(axle) > 0.0 ? 1.0 : -1.0;
    const Vector3d shift = (side * 0.5 * model.width - (beam.points.front() - hub.position).dot(axle)) * axle;
    const Vector3d radial = (beam.points.back() - beam.points.front()).normalized();
    const std::vector<Vector3d> line = strip(beam.points.front() + shift, beam.points.back() + shift,
                                             side * axle, 0.5 * M_PI * (model.radius - model.hub_radius));
    const std::vector<std_msgs::ColorRGBA> paint(line.size(),
                                                 bending_colour(beam.bending.front() / scale.beams));
    add_band(m, line, 0.5 * kStripWidth * axle.cross(radial), paint);
  }
  return m;
}

Marker hub_marker(const FlexibleWheel& wheel) {
  const wheel::HubMotion hub = wheel.hub();
  Marker m = marker("hub", 0, Marker::CYLINDER);
  m.pose.position = point(hub.position);
  const Eigen::Quaterniond q =
      Eigen::AngleAxisd(hub.steering, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitX());
  m.pose.orientation.x = q.x();
  m.pose.orientation.y = q.y();
  m.pose.orientation.z = q.z();
  m.pose.orientation.w = q.w();
  m.scale.x = m.scale.y = 2.0 * wheel.model().hub_radius;
  m.scale.z = wheel.model().width;
  m.color = colour(0.32, 0.35, 0.4);
  return m;
}

std::string legend(const wheel::WheelModel& model, const BendingScale& scale) {
  const double degree = M_PI / 180.0;
  std::string line =
      fmt::format("red: bent tighter, blue: straightened (rim to {:.1f} deg a joint", scale.rim / degree);
  if (model.suspension == Suspension::beams) line += fmt::format(", beams to {:.1f}", scale.beams / degree);
  line += ")";
  if (model.suspension == Suspension::springs)
    line += fmt::format("; springs red: stretched, blue: pressed (to {:.1f} mm)", 1e3 * scale.beams);
  return line;
}

void pack(MarkerArray& array, Marker m, const std::string& frame) {
  m.header.frame_id = frame;
  if (m.type == Marker::TRIANGLE_LIST && m.points.empty()) m.action = Marker::DELETE;
  array.markers.push_back(std::move(m));
}

}  // namespace

sensor_msgs::JointState wheel_joints(const FlexibleWheel& wheel, const std_msgs::Header& header) {
  sensor_msgs::JointState joints;
  joints.header = header;
  const wheel::WheelModel& model = wheel.model();
  const auto add = [&](std::string name, double position, double velocity, double effort) {
    joints.name.push_back(std::move(name));
    joints.position.push_back(position);
    joints.velocity.push_back(velocity);
    joints.effort.push_back(effort);
  };
  const wheel::HubMotion hub = wheel.hub();
  add("wheel", hub.angle, hub.rate,
      wheel.reaction().torque.dot(Vector3d(-std::sin(hub.steering), std::cos(hub.steering), 0.0)));
  if (model.suspension == Suspension::rigid) return joints;
  const int n = wheel.segment_count();
  std::vector<double> rates(n);
  const Vector3d axle{-std::sin(hub.steering), std::cos(hub.steering), 0.0};
  for (int i = 0; i < n; ++i) rates[i] = wheel.segment(i).angular_velocity.dot(axle);
  for (int i = 0; i < n; ++i) {
    const double bending = wheel.rim_bending(i);
    add(fmt::format("rim_{:02}", i), bending, rates[(i + 1) % n] - rates[i],
        -model.rim_joint_stiffness * bending);
  }
  const double unknown = std::nan("");  // the wheel tells how far a beam is bent, not how fast
  for (const BeamState& beam : wheel.beams()) {
    double factor = 1.0;
    for (const wheel::Fault& fault : model.faults)
      if (fault.position == beam.position && fault.set == beam.set) factor *= fault.factor;
    if (model.suspension == Suspension::springs) {
      add(fmt::format("spring_{:02}_{}", beam.position, beam.set), beam.bending.front(), unknown,
          -factor * model.springs.radial_stiffness * beam.bending.front());
      continue;
    }
    for (std::size_t k = 0; k < beam.bending.size(); ++k) {
      const double ends = k == 0 || k + 1 == beam.bending.size() ? 2.0 : 1.0;
      add(fmt::format("beam_{:02}_{}_{:02}", beam.position, beam.set, k), beam.bending[k], unknown,
          -factor * ends * model.beams.joint_stiffness * beam.bending[k]);
    }
  }
  return joints;
}

WheelState wheel_state(const FlexibleWheel& wheel, const std_msgs::Header& header) {
  WheelState state;
  state.header = header;
  state.step = static_cast<std::uint64_t>(wheel.steps());
  for (int i = 0; i < wheel.segment_count(); ++i) {
    const wheel::SegmentState s = wheel.segment(i);
    geometry_msgs::Pose pose;
    pose.position = point(s.position);
    pose.orientation.x = s.orientation.x();
    pose.orientation.y = s.orientation.y();
    pose.orientation.z = s.orientation.z();
    pose.orientation.w = s.orientation.w();
    state.poses.push_back(pose);
    geometry_msgs::Twist twist;
    twist.linear = vector(s.velocity);
    twist.angular = vector(s.angular_velocity);
    state.twists.push_back(twist);
  }
  const wheel::Wrench reaction = wheel.reaction();
  state.reaction.force = vector(reaction.force);
  state.reaction.torque = vector(reaction.torque);
  return state;
}

void obey(FlexibleWheel& wheel, const WheelCommand& command) {
  if (command.step != static_cast<std::uint64_t>(wheel.steps()))
    throw Error(fmt::format("command for step {}: the wheel is at step {}", command.step, wheel.steps()));
  if (!command.segments.empty() && static_cast<int>(command.segments.size()) != wheel.segment_count())
    throw Error(fmt::format("command for step {}: forces on {} segments, the wheel has {}", command.step,
                            command.segments.size(), wheel.segment_count()));
  for (std::size_t i = 0; i < command.segments.size(); ++i)
    wheel.apply(static_cast<int>(i), from(command.segments[i].force), from(command.segments[i].torque));
  wheel::HubMotion hub;
  hub.position = from(command.hub_position);
  hub.velocity = from(command.hub_velocity);
  hub.angle = command.hub_angle;
  hub.rate = command.hub_rate;
  hub.steering = command.steering;
  wheel.step(command.time_step, hub);
}

MarkerArray wheel_markers(const FlexibleWheel& wheel, BendingScale& scale, const std::string& text,
                          const std::string& frame) {
  MarkerArray array;
  Marker rim = marker("rim", 0, Marker::TRIANGLE_LIST);
  const int n = wheel.segment_count();
  std::vector<double> bending(n);
  for (int i = 0; i < n; ++i) {
    bending[i] = wheel.rim_bending(i);
    scale.rim = std::max(scale.rim, std::abs(bending[i]));
  }
  for (int i = 0; i < n; ++i) {
    // A plate takes the colour of the two joints at its ends; grousers stay grey.
    const auto paint = bending_colour(0.5 * (bending[i] + bending[(i + n - 1) % n]) / scale.rim);
    const wheel::SegmentState s = wheel.segment(i);
    const std::vector<wheel::Box>& boxes = wheel.shape(i).boxes;
    for (std::size_t b = 0; b < boxes.size(); ++b)
      add_box(rim, s, boxes[b], b == 0 ? paint : colour(0.55, 0.55, 0.58));
  }
  pack(array, std::move(rim), frame);
  if (wheel.model().suspension != Suspension::rigid) {
    pack(array, beams_marker(wheel, scale), frame);
    pack(array, hub_marker(wheel), frame);
  }
  if (!text.empty()) {
    Marker label = marker("text", 0, Marker::TEXT_VIEW_FACING);
    label.text = text + "\n" + legend(wheel.model(), scale);
    label.scale.z = 0.075 * wheel.model().radius;
    label.color = colour(0.1, 0.1, 0.12);
    label.pose.position = point(wheel.hub().position + Vector3d(0.0, 0.0, 1.35 * wheel.model().radius));
    pack(array, std::move(label), frame);
  }
  return array;
}

MarkerArray ground_markers(const wheel::Ground& ground, const std::string& frame) {
  MarkerArray array;
  int id = 0;
  const auto block = [&](const Vector3d& centre, const Vector3d& size, double pitch,
                         const std_msgs::ColorRGBA& paint) {
    Marker m = marker("ground", id++, Marker::TRIANGLE_LIST);
    wheel::SegmentState pose;
    pose.position = centre;
    pose.orientation = Eigen::AngleAxisd(pitch, Vector3d::UnitY());
    add_box(m, pose, {Vector3d::Zero(), 0.5 * size}, paint);
    pack(array, std::move(m), frame);
  };
  if (ground.floor) block({0.4, 0.0, *ground.floor - 0.005}, {1.4, 0.4, 0.01}, 0.0, colour(0.74, 0.69, 0.6));
  for (const wheel::GroundBox& box : ground.boxes)
    block(box.centre, box.size, box.pitch, colour(0.62, 0.55, 0.45));
  for (const wheel::GroundSphere& sphere : ground.spheres) {
    Marker m = marker("ground", id++, Marker::SPHERE);
    m.pose.position = point(sphere.centre);
    m.scale.x = m.scale.y = m.scale.z = 2.0 * sphere.radius;
    m.color = colour(0.55, 0.5, 0.45);
    pack(array, std::move(m), frame);
  }
  for (const wheel::GroundRock& rock : ground.rocks) {
    Marker m = marker("ground", id++, Marker::TRIANGLE_LIST);
    for (const auto& t : rock.triangles) {
      const Vector3d &a = rock.vertices[t[0]], &b = rock.vertices[t[1]], &c = rock.vertices[t[2]];
      triangle(m, a, b, c, colour(0.55, 0.5, 0.45));
      triangle(m, a, c, b, colour(0.55, 0.5, 0.45));
    }
    pack(array, std::move(m), frame);
  }
  return array;
}

}  // namespace wheel_twin::nodes
