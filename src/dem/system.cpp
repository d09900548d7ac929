#include "dem/system.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "dem/system_impl.h"

namespace wheel_twin::dem {

System::System(const WorldSettings& settings, const MaterialTable& materials,
               std::vector<ClumpTemplate> templates)
    : impl_(std::make_unique<Impl>(settings, materials, std::move(templates))) {}
System::~System() = default;
System::System(System&&) noexcept = default;
System& System::operator=(System&&) noexcept = default;

void System::add(const std::vector<Particle>& particles) {
  if (particles.empty()) return;
  const std::size_t before = size();
  impl_->append(particles);
  try {
    impl_->check_overlaps(before);
  } catch (const Error&) {
    std::vector<bool> which(size(), false);
    for (std::size_t r = before; r < which.size(); ++r) which[r] = true;
    impl_->erase(which);
    throw;
  }
}

void System::remove(const std::vector<bool>& which) {
  impl_->erase(which);
}

std::uint32_t System::add_wall(const Wall& wall) {
  if (wall.material >= impl_->materials.size()) {
    throw Error(
        fmt::format("wall '{}': material {} of {}", wall.name, wall.material, impl_->materials.size()));
  }
  const std::uint32_t number = impl_->walls.add(wall);
  impl_->wake_all();
  if (!impl_->stale) impl_->pending = impl_->collect_histories();
  impl_->stale = true;
  return number;
}

void System::remove_wall(std::uint32_t wall) {
  impl_->walls.remove(wall);
  impl_->wake_all();
  if (!impl_->stale) impl_->pending = impl_->collect_histories();
  impl_->stale = true;
}

void System::set_wall_motion(std::uint32_t wall, const Motion& motion) {
  impl_->walls.set_motion(wall, motion);
}
void System::set_wall_pose(std::uint32_t wall, const Pose& pose, const Motion& motion) {
  impl_->walls.set_pose(wall, pose, motion);
}
void System::set_wall_shape(std::uint32_t wall, const Mesh& mesh) {
  impl_->walls.set_mesh(wall, mesh);
}
const Wall& System::wall(std::uint32_t wall) const {
  return impl_->walls.parts().at(wall).wall;
}
Wrench System::wall_wrench(std::uint32_t wall) const {
  const auto& sum = impl_->walls.parts().at(wall).wrench;
  return {{sum[0], sum[1], sum[2]}, {sum[3], sum[4], sum[5]}};
}
std::size_t System::wall_count() const {
  return impl_->walls.parts().size();
}

void System::step(int count) {
  for (int k = 0; k < count; ++k) impl_->step_once();
}

std::int64_t System::step_number() const {
  return impl_->step;
}
double System::time() const {
  return static_cast<double>(impl_->step) * impl_->time_step;
}
double System::time_step() const {
  return impl_->time_step;
}
double System::rayleigh_step() const {
  return impl_->rayleigh;
}
const WorldSettings& System::settings() const {
  return impl_->settings;
}
const MaterialTable& System::materials() const {
  return impl_->materials;
}
const std::vector<ClumpTemplate>& System::templates() const {
  return impl_->templates;
}

void System::set_pair(std::uint32_t material_a, std::uint32_t material_b, const PairProperties& properties) {
  Impl& s = *impl_;
  s.wake_all();
  s.materials.set_pair(material_a, material_b, properties);
  const bool rolled = s.law.rolling;
  s.prepare_laws();
  if (s.law.rolling != rolled && !s.stale) {
    s.pending = s.collect_histories();
    s.stale = true;
  }
}
void System::hold_beyond(double middle, double half_length) {
  if (!impl_->settings.sleep.enabled) throw Error("world: a window needs sleep, which is not enabled");
  if (!std::isfinite(middle) || !(half_length > 0.0))
    throw Error(fmt::format("world: a window of {} m around {} m", half_length, middle));
  impl_->hold_beyond(middle, half_length);
}
void System::set_gravity(const Eigen::Vector3d& gravity) {
  if (!gravity.allFinite()) throw Error("world: gravity is not finite");
  impl_->wake_all();
  impl_->settings.gravity = gravity;
}
void System::set_threads(int threads) {
  Impl& s = *impl_;
  if (threads < 1 || threads > 256) throw Error(fmt::format("world: {} threads", threads));
  if (!s.stale) s.pending = s.collect_histories();
  s.stale = true;
  s.settings.threads = threads;
  s.team = std::make_unique<ThreadTeam>(static_cast<std::size_t>(threads));
  auto touches = s.walls.take_touches();
  s.awake_end = s.bodies.count;
  s.renumber();
  s.walls.put_touches(std::move(touches), s.spheres, s.bounds);
}

void System::stop_all() {
  Impl& s = *impl_;
  for (std::size_t b = 0; b < s.bodies.count; ++b) {
    for (int a = 0; a < 3; ++a) s.bodies.v[a][b] = s.bodies.l[a][b] = 0.0;
  }
}

std::size_t System::size() const {
  return impl_->bodies.count;
}
std::size_t System::sphere_count() const {
  return impl_->spheres.count;
}
double System::mass(std::size_t index) const {
  return impl_->mass_of(impl_->index_of_rank.at(index));
}

Eigen::Vector3d System::Impl::full_velocity(std::size_t b) const {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  if (bodies.asleep[b] != 0) return v;
  for (int a = 0; a < 3; ++a) {
    v[a] = bodies.v[a][b] +
           0.5 * time_step * (settings.gravity[a] + bodies.load[b].force[a] * bodies.inverse_mass[b]);
  }
  return v;
}

Eigen::Vector3d System::Impl::full_momentum(std::size_t b) const {
  Eigen::Vector3d l = Eigen::Vector3d::Zero();
  if (bodies.asleep[b] != 0) return l;
  for (int a = 0; a < 3; ++a) l[a] = bodies.l[a][b] + 0.5 * time_step * bodies.load[b].torque[a];
  return l;
}

Eigen::Matrix3d System::Impl::rotation(std::size_t b) const {
  if (only_spheres) return Eigen::Matrix3d::Identity();
  return Eigen::Quaterniond(bodies.q[0][b], bodies.q[1][b], bodies.q[2][b], bodies.q[3][b])
      .toRotationMatrix();
}

Eigen::Vector3d System::Impl::spin_of(std::size_t b, const Eigen::Vector3d& momentum) const {
  if (only_spheres) return bodies.inverse_inertia[0][b] * momentum;
  const Eigen::Matrix3d r = rotation(b);
  Eigen::Vector3d spin = r.transpose() * momentum;
  for (int a = 0; a < 3; ++a) spin[a] *= bodies.inverse_inertia[a][b];
  return r * spin;
}

Eigen::Vector3d System::Impl::momentum_of(std::size_t b, const Eigen::Vector3d& spin) const {
  if (only_spheres) return spin / bodies.inverse_inertia[0][b];
  const Eigen::Matrix3d r = rotation(b);
  Eigen::Vector3d momentum = r.transpose() * spin;
  for (int a = 0; a < 3; ++a) momentum[a] /= bodies.inverse_inertia[a][b];
  return r * momentum;
}

Particle System::Impl::particle_of(std::size_t b) const {
  Particle p;
  p.shape = bodies.shape[b];
  p.material = bodies.material[b];
  p.size = bodies.size[b];
  p.stiffness = bodies.stiffness[b];
  p.position = {bodies.x[0][b], bodies.x[1][b], bodies.x[2][b]};
  if (!only_spheres) p.orientation = {bodies.q[0][b], bodies.q[1][b], bodies.q[2][b], bodies.q[3][b]};
  p.velocity = full_velocity(b);
  p.angular_velocity = spin_of(b, full_momentum(b));
  return p;
}

Particle System::particle(std::size_t index) const {
  return impl_->particle_of(impl_->index_of_rank.at(index));
}

std::vector<Particle> System::particles() const {
  std::vector<Particle> all;
  all.reserve(size());
  for (const auto b : impl_->index_of_rank) all.push_back(impl_->particle_of(b));
  return all;
}

void System::set_velocity(std::size_t index, const Eigen::Vector3d& velocity,
                          const Eigen::Vector3d& angular_velocity) {
  Impl& s = *impl_;
  const std::size_t b = s.index_of_rank.at(index);
  s.wake_all();
  const Eigen::Vector3d momentum = s.momentum_of(b, angular_velocity);
  for (int a = 0; a < 3; ++a) {
    s.bodies.v[a][b] =
        velocity[a] -
        0.5 * s.time_step * (s.settings.gravity[a] + s.bodies.load[b].force[a] * s.bodies.inverse_mass[b]);
    s.bodies.l[a][b] = momentum[a] - 0.5 * s.time_step * s.bodies.load[b].torque[a];
  }
}

std::vector<SphereState> System::spheres() const {
  const Impl& s = *impl_;
  std::vector<SphereState> all;
  all.reserve(s.spheres.count);
  for (std::size_t r = 0; r < s.bodies.count; ++r) {
    const std::size_t b = s.index_of_rank[r];
    for (std::uint32_t k = 0; k < s.shapes.count[s.bodies.shape[b]]; ++k) {
      const SphereRow& row = s.spheres.row[s.bodies.first[b] + k];
      all.push_back({{row.x[0], row.x[1], row.x[2]}, row.radius, static_cast<std::uint32_t>(r)});
    }
  }
  return all;
}

std::vector<Wrench> System::loads() const {
  std::vector<Wrench> all;
  all.reserve(size());
  for (const auto b : impl_->index_of_rank) {
    const LoadRow& row = impl_->bodies.load[b];
    all.push_back(
        {{row.force[0], row.force[1], row.force[2]}, {row.torque[0], row.torque[1], row.torque[2]}});
  }
  return all;
}

}  // namespace wheel_twin::dem
