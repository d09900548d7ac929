#include "dem/soil_export.h"

#include "dem/vtk.h"

namespace wheel_twin::dem {

void write_spheres_vtp(const std::string& path, const System& system) {
  const std::vector<SphereState> spheres = system.spheres();
  const std::vector<Particle> particles = system.particles();
  const std::vector<Wrench> loads = system.loads();
  VtkPolyData data;
  VtkField radius{"radius", 1, {}};
  VtkField velocity{"velocity", 3, {}};
  VtkField force{"force", 3, {}};
  VtkField clump{"clump", 1, {}};
  VtkField shape{"shape", 1, {}};
  const auto append = [](std::vector<float>& to, const Eigen::Vector3d& v) {
    for (int k = 0; k < 3; ++k) to.push_back(static_cast<float>(v[k]));
  };
  for (const SphereState& sphere : spheres) {
    const Particle& p = particles[sphere.particle];
    append(data.points, sphere.center);
    radius.values.push_back(static_cast<float>(sphere.radius));
    append(velocity.values, p.velocity + p.angular_velocity.cross(sphere.center - p.position));
    append(force.values,
           sphere.particle < loads.size() ? loads[sphere.particle].force : Eigen::Vector3d::Zero());
    clump.values.push_back(static_cast<float>(sphere.particle));
    shape.values.push_back(static_cast<float>(p.shape));
  }
  data.fields = {radius, velocity, force, clump, shape};
  write_vtp(path, data);
}

}  // namespace wheel_twin::dem
