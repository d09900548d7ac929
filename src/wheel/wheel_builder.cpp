#include "wheel/wheel_builder.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::wheel {
namespace {

struct Place {  ///< on the rim
  int segment = 0;
  double offset = 0.0;  ///< along the segment's x, m
};

Place on_rim(const WheelModel& model, double angle) {
  const double pitch = 2.0 * M_PI / model.segments;
  const int nearest = static_cast<int>(std::lround(angle / pitch));
  const double apothem = model.radius * std::cos(0.5 * pitch);
  return {nearest % model.segments, apothem * std::tan(angle - nearest * pitch)};
}

Vec2 direction(double angle) {
  return {std::sin(angle), std::cos(angle)};
}

double factor_of(const WheelModel& model, int position, int set) {
  double factor = 1.0;
  for (const Fault& fault : model.faults) {
    if (fault.position == position && fault.set == set) factor *= fault.factor;
  }
  return factor;
}

void add_segments(const WheelModel& model, BuiltWheel& built) {
  const double length = segment_length(model);
  const double apothem = model.radius * std::cos(M_PI / model.segments);
  const double thickness = model.rim.thickness;
  const double half_width = 0.5 * model.width;
  const double plate = model.rim.density * model.width * thickness * length;
  for (int i = 0; i < model.segments; ++i) {
    BuiltSegment segment;
    segment.angle = 2.0 * M_PI * i / model.segments;
    segment.shape.boxes.push_back({{0.0, 0.0, 0.0}, {0.5 * length, half_width, 0.5 * thickness}});
    built.segments.push_back(segment);
  }
  const double h = model.grouser_height;
  if (h > 0.0) {
    for (int g = 0; g < model.grousers; ++g) {
      const Place place = on_rim(model, 2.0 * M_PI * g / model.grousers);
      built.segments[place.segment].shape.boxes.push_back(
          {{place.offset, 0.0, 0.5 * (thickness + h)}, {0.5 * model.grouser_thickness, half_width, 0.5 * h}});
    }
  }
  for (BuiltSegment& segment : built.segments) {
    double mass = plate;
    double inertia = plate * (length * length + thickness * thickness) / 12.0;  // about the reference point
    Vec2 moment;
    for (std::size_t b = 1; b < segment.shape.boxes.size(); ++b) {
      const double t = model.grouser_thickness;
      const double m = model.rim.density * model.width * t * h;
      const Vec2 at{segment.shape.boxes[b].centre.x(), segment.shape.boxes[b].centre.z()};
      mass += m;
      moment = moment + m * at;
      inertia += m * ((t * t + h * h) / 12.0 + dot(at, at));
    }
    const Vec2 centre = (1.0 / mass) * moment;
    segment.reference = -1.0 * centre;
    PlanarBody body;
    body.mass = mass;
    body.inertia = inertia - mass * dot(centre, centre);
    body.angle = segment.angle;
    const Vec2 outward = direction(segment.angle);
    segment.reference_on_hub = apothem * outward;
    const Vec2 forward{outward.z, -outward.x};
    body.position = segment.reference_on_hub + centre.x * forward + centre.z * outward;
    built.rim_mass += mass;
    built.rim_inertia += body.inertia + mass * dot(body.position, body.position);
    built.parts.bodies.push_back(body);
  }
}

void add_springs(const WheelModel& model, BuiltWheel& built) {
  for (int position = 0; position < model.springs.positions; ++position) {
    const double angle = 2.0 * M_PI * position / model.springs.positions;
    const Place place = on_rim(model, angle);
    for (int set = 0; set < model.springs.sets; ++set) {
      const double factor = factor_of(model, position, set);
      if (factor == 0.0) continue;
      PlanarSpring spring;
      spring.body = place.segment;
      spring.at_body = built.segments[place.segment].reference + Vec2{place.offset, 0.0};
      spring.direction = direction(angle);
      spring.radial = factor * model.springs.radial_stiffness;
      built.beams.push_back({position, set, static_cast<int>(built.parts.springs.size()), -1, -1, angle});
      built.parts.springs.push_back(spring);
      PlanarSpring across = spring;
      across.radial = 0.0;
      across.at_body.z -= model.springs.tangential_depth;
      across.tangential = factor * model.springs.tangential_stiffness;
      across.turning = factor * model.springs.turning_stiffness;
      if (across.tangential > 0.0 || across.turning > 0.0) built.parts.springs.push_back(across);
    }
  }
}

/// A semicircle from the hub's surface to the rim, as a chain of straight bodies with its vertices on the
/// arc. Clamped at both ends: half a body's length of bending, so twice the stiffness.
void add_beam(const WheelModel& model, int position, int set, double factor, BuiltWheel& built) {
  const double angle = 2.0 * M_PI * position / model.beams.positions;
  const Place place = on_rim(model, angle);
  const BuiltSegment& segment = built.segments[place.segment];
  const Vec2 outward = direction(angle);
  const Vec2 forward{outward.z, -outward.x};
  const double end = model.radius * std::cos(M_PI / model.segments) / std::cos(angle - segment.angle);
  const double radius = 0.5 * (end - model.hub_radius);
  const double curl = set % 2 == 0 ? 1.0 : -1.0;
  const int n = model.beams.bodies;
  const auto vertex = [&](int k) {
    const double s = M_PI * k / n;
    return (model.hub_radius + radius * (1.0 - std::cos(s))) * outward +
           curl * radius * std::sin(s) * forward;
  };
  const int hub = -1;  // replaced once the number of bodies is known
  const int first = static_cast<int>(built.parts.bodies.size());
  built.beams.push_back({position, set, -1, first, static_cast<int>(built.parts.joints.size()), angle});
  const double half = radius * std::sin(0.5 * M_PI / n);
  const Sheet& sheet = model.beams.sheet;
  for (int k = 0; k < n; ++k) {
    PlanarBody body;
    const Vec2 chord = vertex(k + 1) - vertex(k);
    body.position = 0.5 * (vertex(k) + vertex(k + 1));
    body.angle = std::atan2(-chord.z, chord.x);
    if (k > 0) {
      const double before = built.parts.bodies.back().angle;
      body.angle = before + std::remainder(body.angle - before, 2.0 * M_PI);
    }
    body.mass = sheet.density * sheet.width * sheet.thickness * 2.0 * half;
    body.inertia = body.mass * (4.0 * half * half + sheet.thickness * sheet.thickness) / 12.0;
    PlanarJoint joint;
    joint.a = first + k;
    joint.at_a = {-half, 0.0};
    joint.b = k == 0 ? hub : first + k - 1;
    joint.at_b = k == 0 ? vertex(0) : Vec2{half, 0.0};
    joint.stiffness = factor * (k == 0 ? 2.0 : 1.0) * model.beams.joint_stiffness;
    built.rim_mass += body.mass;
    built.rim_inertia += body.inertia + body.mass * dot(body.position, body.position);
    built.parts.bodies.push_back(body);
    built.parts.joints.push_back(joint);
  }
  PlanarJoint joint;
  joint.a = place.segment;
  joint.at_a = segment.reference + Vec2{place.offset, 0.0};
  joint.b = first + n - 1;
  joint.at_b = {half, 0.0};
  joint.stiffness = factor * 2.0 * model.beams.joint_stiffness;
  built.parts.joints.push_back(joint);
}

void add_ring(const WheelModel& model, BuiltWheel& built) {
  const double half = 0.5 * segment_length(model);
  for (int i = 0; i < model.segments; ++i) {
    PlanarJoint joint;
    joint.a = i;
    joint.b = (i + 1) % model.segments;
    joint.at_a = built.segments[joint.a].reference + Vec2{half, 0.0};
    joint.at_b = built.segments[joint.b].reference - Vec2{half, 0.0};
    joint.stiffness = model.rim_joint_stiffness;
    built.parts.joints.push_back(joint);
  }
}

}  // namespace

BuiltWheel build(const WheelModel& model) {
  BuiltWheel built;
  add_segments(model, built);
  built.parts.hub_mass = model.hub_mass;
  built.parts.hub_inertia = model.hub_inertia;
  if (model.suspension == Suspension::rigid) {
    built.parts.bodies.clear();
    built.parts.hub_mass += built.rim_mass;
    built.parts.hub_inertia += built.rim_inertia;
    return built;
  }
  if (model.suspension == Suspension::springs) add_springs(model, built);
  if (model.suspension == Suspension::beams) {
    for (int position = 0; position < model.beams.positions; ++position) {
      for (int set = 0; set < model.beams.sets; ++set) {
        const double factor = factor_of(model, position, set);
        if (factor > 0.0) add_beam(model, position, set, factor, built);
      }
    }
  }
  add_ring(model, built);
  const int hub = static_cast<int>(built.parts.bodies.size());
  for (PlanarJoint& joint : built.parts.joints) {
    if (joint.b < 0) joint.b = hub;
  }
  built.parts.damping_time = model.damping_ratio / (M_PI * model.damping_frequency);
  return built;
}

}  // namespace wheel_twin::wheel
