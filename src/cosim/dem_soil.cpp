#include "cosim/dem_soil.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "cosim/soil_change.h"
#include "cosim/wheel_faces.h"
#include "dem/state_file.h"

namespace wheel_twin::cosim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Longest step (s) at which the forces of the stiffest grains, exchanged once a step, do not make a rim
/// segment of this mobility (1/kg) swing up: a share of 2 / omega of the segment on the contact stiffness
/// (Hertz) of a hard-pressed grain.
double steady_exchange(const dem::MaterialTable& materials, std::uint32_t grain_materials,
                       const std::vector<dem::ClumpTemplate>& templates, double mobility) {
  constexpr double pressed = 20.0;  // N on a grain
  constexpr double share = 0.45;    // several grains press at once: 0.7 swung up, 0.55 trembled, 0.48 did not
  double radius = 0.0;
  for (const dem::ClumpTemplate& one : templates)
    for (const dem::ClumpSphere& sphere : one.spheres) radius = std::max(radius, sphere.radius);
  const auto compliance = [](const dem::Material& m) {
    return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus();
  };
  double modulus = 0.0;
  for (std::uint32_t i = 0; i < grain_materials; ++i)
    modulus = std::max(modulus, 1.0 / (compliance(materials[i]) + compliance(materials[grain_materials])));
  const double overlap = std::pow(0.75 * pressed / (modulus * std::sqrt(radius)), 2.0 / 3.0);
  const double stiffness = 2.0 * modulus * std::sqrt(radius * overlap);
  return share * 2.0 / std::sqrt(stiffness * mobility);
}

/// The engine with the bed in it and a step of which `settings.rig_step` is a multiple.
dem::System make_system(const dem::GranularSoil& soil, const dem::Bed& bed, const ChangedBed& changed,
                        const DemSoilSettings& settings, const Matrix3d& bed_from_rig) {
  const dem::System plain = dem::bed_world(soil, bed.settings, settings.headroom, settings.threads);
  dem::WorldSettings world = plain.settings();
  world.particle_materials = changed.grain_materials;
  world.track_energy = settings.track_energy;
  world.sleep = settings.sleep;
  if (settings.window && !world.sleep.enabled) {
    world.sleep.enabled = true;
    world.sleep.speed = 0.0;
  }
  world.gravity = bed_from_rig * world.gravity;
  double longest = settings.step_fraction.value_or(soil.step_fraction) * plain.rayleigh_step();
  if (settings.rim_mobility > 0.0)
    longest = std::min(longest, steady_exchange(changed.materials, world.particle_materials,
                                                plain.templates(), settings.rim_mobility));
  world.time_step = settings.rig_step / std::ceil(settings.rig_step / longest);
  dem::System system(world, changed.materials, plain.templates());
  system.restore(changed.state);
  return system;
}

Matrix3d turn_about_y(double slope) {
  // The surface rises along the rig's x: its direction is (cos, 0, sin) in rig axes.
  Matrix3d bed_from_rig;
  bed_from_rig << std::cos(slope), 0.0, std::sin(slope), 0.0, 1.0, 0.0, -std::sin(slope), 0.0,
      std::cos(slope);
  return bed_from_rig;
}

}  // namespace

DemSoil::DemSoil(const dem::GranularSoil& soil, const dem::Bed& bed,
                 const std::vector<wheel::SegmentShape>& wheel, const DemSoilSettings& settings,
                 const std::vector<const rig::SoilPort*>& ports)
    : DemSoil(soil, bed, change_bed(soil, bed, settings.start_x, ports), wheel, settings) {}

DemSoil::DemSoil(const dem::GranularSoil& soil, const dem::Bed& bed, const ChangedBed& changed,
                 const std::vector<wheel::SegmentShape>& wheel, const DemSoilSettings& settings)
    : bed_from_rig_(turn_about_y(changed.slope)),
      start_x_(settings.start_x),
      window_(settings.window),
      good_until_(changed.good_until),
      system_(make_system(soil, bed, changed, settings, bed_from_rig_)) {
  if (changed.changed) {
    constexpr double settling_time = 0.005;  // s between two quenches
    for (int quench = 0; quench < 10; ++quench) {
      system_.step(static_cast<int>(std::ceil(settling_time / system_.time_step())));
      system_.stop_all();
    }
  }
  const std::vector<dem::Mesh> faces = wheel_faces(wheel);
  const auto wall_material = static_cast<std::uint32_t>(system_.settings().particle_materials);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    dem::Wall wall;
    wall.name = fmt::format("rim segment {}", i);
    wall.material = wall_material;
    wall.shape = faces[i];
    wall.pose.position = {0.0, 0.0, settings.headroom + 1.0};  // out of the way until the first step
    wall.surface = 0;
    const std::uint32_t number = system_.add_wall(wall);
    if (i == 0) first_wall_ = number;
  }
  loads_.resize(faces.size());
}

Vector3d DemSoil::to_bed(const Vector3d& point_rig) const {
  return bed_from_rig_ * point_rig + Vector3d(start_x_, 0.0, 0.0);
}

Vector3d DemSoil::to_rig(const Vector3d& point_bed) const {
  return bed_from_rig_.transpose() * (point_bed - Vector3d(start_x_, 0.0, 0.0));
}

const std::vector<wheel::Wrench>& DemSoil::advance(std::int64_t /*step*/,
                                                   const std::vector<wheel::SegmentState>& segments) {
  // Two opposite segments lie about the hub.
  const double hub = 0.5 * (segments.front().position.x() + segments[segments.size() / 2].position.x());
  if (hub > good_until_)
    throw Error(
        fmt::format("fidelity dem: an effect varies along the bed, which comes round {:.3f} m from the "
                    "start: make the run shorter or the "
                    "bed longer",
                    good_until_));
  if (window_)
    system_.hold_beyond(start_x_ + hub + 0.5 * (window_->ahead - window_->behind),
                        0.5 * (window_->ahead + window_->behind));
  const Eigen::Quaterniond turn(bed_from_rig_);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const wheel::SegmentState& segment = segments[i];
    system_.set_wall_pose(first_wall_ + static_cast<std::uint32_t>(i),
                          {to_bed(segment.position), turn * segment.orientation},
                          {bed_from_rig_ * segment.velocity, bed_from_rig_ * segment.angular_velocity});
  }
  system_.step();
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    const dem::Wrench wrench = system_.wall_wrench(first_wall_ + static_cast<std::uint32_t>(i));
    loads_[i].force = bed_from_rig_.transpose() * wrench.force;
    loads_[i].torque = bed_from_rig_.transpose() * wrench.torque;
  }
  return loads_;
}

double DemSoil::first_touch(double x, double radius, double width) const {
  const dem::WorldSettings& world = system_.settings();
  const double length = world.high.x() - world.low.x();
  double height = -1e30;
  for (const dem::SphereState& sphere : system_.spheres()) {
    Vector3d center = sphere.center;
    if (std::abs(center.y()) > 0.5 * width + sphere.radius) continue;
    const double middle = to_bed({x, 0.0, 0.0}).x();
    if (world.periodic_x) center.x() -= length * std::round((center.x() - middle) / length);
    center = to_rig(center);
    const double reach = radius + sphere.radius;
    const double along = center.x() - x;
    if (std::abs(along) < reach)
      height = std::max(height, center.z() + std::sqrt(reach * reach - along * along));
  }
  return height;
}

std::string DemSoil::fingerprint() const {
  const std::string system = dem::system_fingerprint(system_);
  return window_ ? fmt::format("{} window {:.17g} {:.17g}", system, window_->behind, window_->ahead) : system;
}

}  // namespace wheel_twin::cosim
