#include "cosim/frame.h"

#include "cosim/grains.h"
#include "cosim/wheel_faces.h"
#include "dem/archive.h"

namespace wheel_twin::cosim {
namespace {

using Eigen::Vector3d;

void put(std::vector<float>& out, const Vector3d& v) {
  for (int i = 0; i < 3; ++i) out.push_back(static_cast<float>(v[i]));
}

std::vector<float> grains(const DemSoil& soil, double hub_x) {
  const std::vector<dem::SphereState> spheres = spheres_about(soil, hub_x);
  const std::vector<SphereMotion> motions = sphere_motions(soil.system());
  std::vector<float> out;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    put(out, spheres[i].center);
    for (const double value : {spheres[i].radius, motions[i].speed, motions[i].force})
      out.push_back(static_cast<float>(value));
  }
  return out;
}

}  // namespace

void write_frame(const std::string& path, const DemContact& contact, const rig::RigStep& step) {
  const wheel::FlexibleWheel& wheel = contact.coupled().wheel();
  const wheel::HubMotion hub = wheel.hub();
  dem::Archive archive;
  archive.set("spheres", grains(contact.soil(), hub.position.x()), 6);

  std::vector<float> corners, bending, springs, force;
  const std::vector<dem::Mesh> faces = wheel_faces(segment_shapes(wheel));
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const wheel::SegmentState segment = wheel.segment(static_cast<int>(i));
    for (const auto& triangle : faces[i].triangles) {
      for (const std::uint32_t corner : triangle)
        put(corners, segment.position + segment.orientation * faces[i].vertices[corner]);
      bending.push_back(static_cast<float>(wheel.rim_bending(static_cast<int>(i))));
    }
  }
  for (const wheel::BeamState& beam : wheel.beams()) {
    for (std::size_t i = 1; i < beam.points.size(); ++i) {
      put(springs, beam.points[i - 1]);
      put(springs, beam.points[i]);
    }
  }
  put(force, step.load.force_hub_rig);
  archive.set("wheel", corners, 9);
  archive.set("bending", bending);
  archive.set("springs", springs, 6);
  archive.set("force", force);
  archive.set_number("time", step.state.time);
  archive.set_number("slip", step.state.slip);
  archive.set_number("hub_x", hub.position.x());
  archive.set_number("hub_z", hub.position.z());
  archive.set_number("sinkage", step.state.hub_displacement);
  archive.set_number("drive_torque", step.load.drive_torque);
  archive.set_number("rim_radius", contact.coupled().radius());
  dem::write_archive(path, "frame", archive);
}

}  // namespace wheel_twin::cosim
