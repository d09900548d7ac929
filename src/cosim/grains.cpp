#include "cosim/grains.h"

#include <cmath>

namespace wheel_twin::cosim {

std::vector<SphereMotion> sphere_motions(const dem::System& system) {
  const std::vector<dem::Particle> particles = system.particles();
  const std::vector<dem::Wrench> loads = system.loads();
  std::vector<SphereMotion> motions;
  for (const dem::SphereState& s : system.spheres()) {
    const dem::Particle& p = particles[s.particle];
    motions.push_back({(p.velocity + p.angular_velocity.cross(s.center - p.position)).norm(),
                       s.particle < loads.size() ? loads[s.particle].force.norm() : 0.0});
  }
  return motions;
}

std::vector<dem::SphereState> spheres_about(const DemSoil& soil, double x) {
  const dem::WorldSettings& world = soil.system().settings();
  const double period = world.high.x() - world.low.x();
  const double middle = soil.to_bed({x, 0.0, 0.0}).x();
  std::vector<dem::SphereState> spheres = soil.system().spheres();
  for (dem::SphereState& sphere : spheres) {
    if (world.periodic_x) sphere.center.x() += period * std::round((middle - sphere.center.x()) / period);
    sphere.center = soil.to_rig(sphere.center);
  }
  return spheres;
}

}  // namespace wheel_twin::cosim
