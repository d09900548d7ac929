#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "dem/system_impl.h"

namespace wheel_twin::dem {

State System::state() const {
  const Impl& s = *impl_;
  const Bodies& bodies = s.bodies;
  State state;
  state.step = s.step;
  for (const auto b : s.index_of_rank) {
    state.shape.push_back(bodies.shape[b]);
    state.material.push_back(bodies.material[b]);
    state.size.push_back(bodies.size[b]);
    state.stiffness.push_back(bodies.stiffness[b]);
    state.position.emplace_back(bodies.x[0][b], bodies.x[1][b], bodies.x[2][b]);
    state.velocity.emplace_back(bodies.v[0][b], bodies.v[1][b], bodies.v[2][b]);
    state.angular_momentum.emplace_back(bodies.l[0][b], bodies.l[1][b], bodies.l[2][b]);
    if (s.only_spheres) {
      state.orientation.emplace_back(1.0, 0.0, 0.0, 0.0);
    } else {
      state.orientation.emplace_back(bodies.q[0][b], bodies.q[1][b], bodies.q[2][b], bodies.q[3][b]);
    }
    const LoadRow& load = bodies.load[b];
    Eigen::Matrix<double, 7, 1> sum;
    sum << load.force[0], load.force[1], load.force[2], load.torque[0], load.torque[1], load.torque[2],
        load.pressure;
    state.load.push_back(sum);
  }
  if (s.settings.sleep.enabled) {
    for (const auto b : s.index_of_rank) state.asleep.push_back(bodies.asleep[b]);
    state.quiet = s.quiet;
    state.looked_at = s.looked_at;
    state.hold = s.hold;
  }
  state.contacts = s.stale ? s.pending : s.collect_histories();
  for (std::size_t t = 0; t < s.walls.threads(); ++t) {
    for (const auto& touch : s.walls.touches(t)) {
      ContactHistory h;
      h.a = s.number_of(touch.sphere);
      h.b = touch.part;
      h.facet = touch.facet;
      h.overlap = touch.overlap;
      for (int a = 0; a < 3; ++a) {
        h.shear[a] = touch.shear[a];
        h.rolling[a] = touch.rolling[a];
      }
      state.wall_contacts.push_back(h);
    }
  }
  for (const auto& part : s.walls.parts()) {
    state.walls.push_back(part.wall);
    state.wall_removed.push_back(part.removed ? 1 : 0);
  }
  return state;
}

void System::restore(const State& state) {
  Impl& s = *impl_;
  const std::size_t n = state.shape.size();
  const auto refuse = [](const std::string& what) { throw Error("restoring a state: " + what); };
  if (state.material.size() != n || state.size.size() != n || state.stiffness.size() != n ||
      state.position.size() != n || state.velocity.size() != n || state.angular_momentum.size() != n ||
      state.orientation.size() != n || state.load.size() != n ||
      state.wall_removed.size() != state.walls.size() ||
      (!state.asleep.empty() && state.asleep.size() != n) ||
      (!state.hold.empty() && state.hold.size() != 2)) {
    refuse("its columns differ in length");
  }
  std::size_t sphere_count = 0;
  for (std::size_t r = 0; r < n; ++r) {
    if (state.shape[r] >= s.templates.size()) {
      refuse(fmt::format("particle {} has template {} of {}", r, state.shape[r], s.templates.size()));
    }
    if (state.material[r] >= s.settings.particle_materials) {
      refuse(fmt::format("particle {} has material {}", r, state.material[r]));
    }
    bool sound = state.size[r] >= s.settings.smallest_size * (1.0 - 1e-6) && state.stiffness[r] > 0.0F &&
                 state.velocity[r].allFinite() && state.angular_momentum[r].allFinite() &&
                 std::fabs(state.orientation[r].norm() - 1.0) < 1e-6;
    for (int a = 0; a < 3; ++a) {
      sound = sound && state.position[r][a] >= s.period.low[a] && state.position[r][a] <= s.period.high[a];
    }
    if (!sound) refuse(fmt::format("particle {} is not sound or outside the domain", r));
    sphere_count += s.shapes.count[state.shape[r]];
  }
  for (const auto& h : state.contacts) {
    if (h.a >= sphere_count || h.b >= sphere_count) refuse("a contact names a sphere that is not there");
  }
  for (const auto& h : state.wall_contacts) {
    if (h.a >= sphere_count || h.b >= state.walls.size()) refuse("a contact names a wall that is not there");
  }
  WallSet walls;
  for (std::size_t w = 0; w < state.walls.size(); ++w) {
    if (state.walls[w].material >= s.materials.size()) refuse("a wall's material is not there");
    const std::uint32_t number = walls.add(state.walls[w]);
    walls.parts()[number].wall = state.walls[w];
    place_facets(state.walls[w], walls.parts()[number].facets);
    if (state.wall_removed[w] != 0) walls.remove(number);
  }
  s.walls = std::move(walls);
  s.step = state.step;
  s.resize(n, sphere_count);
  std::uint32_t next = 0;
  for (std::size_t b = 0; b < n; ++b) {
    s.bodies.shape[b] = static_cast<std::uint16_t>(state.shape[b]);
    s.bodies.material[b] = static_cast<std::uint16_t>(state.material[b]);
    s.bodies.size[b] = state.size[b];
    s.bodies.stiffness[b] = state.stiffness[b];
    s.bodies.rank[b] = static_cast<std::uint32_t>(b);
    s.bodies.first[b] = next;
    for (std::uint32_t k = 0; k < s.shapes.count[state.shape[b]]; ++k)
      s.spheres.body[next++] = static_cast<std::uint32_t>(b);
    s.set_mass(b);
    for (int a = 0; a < 3; ++a) {
      s.bodies.x[a][b] = state.position[b][a];
      s.bodies.v[a][b] = state.velocity[b][a];
      s.bodies.l[a][b] = state.angular_momentum[b][a];
      s.bodies.load[b].force[a] = state.load[b][a];
      s.bodies.load[b].torque[a] = state.load[b][3 + a];
    }
    s.bodies.load[b].pressure = state.load[b][6];
    if (!s.only_spheres) {
      for (int a = 0; a < 4; ++a) s.bodies.q[a][b] = state.orientation[b][a];
    }
  }
  // A state of a system without sleep, or with other cells, starts awake.
  const bool sleeps =
      s.settings.sleep.enabled && !state.asleep.empty() && state.quiet.size() == s.quiet.size();
  for (std::size_t b = 0; b < n; ++b) s.bodies.asleep[b] = sleeps ? state.asleep[b] : 0;
  if (sleeps) {
    s.quiet = state.quiet;
    s.looked_at = state.looked_at;
    s.hold = state.hold;
  } else {
    std::fill(s.quiet.begin(), s.quiet.end(), 0U);
    s.looked_at.clear();
    s.hold.clear();
  }
  s.mark_held();
  s.dormant.clear();
  s.awake_end = n;
  s.renumber();
  place_spheres(s.motion_task(), 0, s.bodies.load.size() - kBatch);
  std::vector<WallSet::Touch> touches;
  for (const auto& h : state.wall_contacts) {
    WallSet::Touch touch{};
    touch.sphere = h.a;
    touch.part = h.b;
    touch.facet = h.facet;
    touch.overlap = h.overlap;
    for (int a = 0; a < 3; ++a) {
      touch.shear[a] = h.shear[a];
      touch.rolling[a] = h.rolling[a];
    }
    touches.push_back(touch);
  }
  s.walls.put_touches(std::move(touches), s.spheres, s.bounds);
  s.pending = state.contacts;
  std::sort(s.pending.begin(), s.pending.end(), [](const ContactHistory& p, const ContactHistory& q) {
    return p.a != q.a ? p.a < q.a : p.b < q.b;
  });
  s.lists.clear();
  s.stale = true;
  s.losses = LossBook{};
}

std::vector<ContactForce> System::contacts() const {
  const Impl& s = *impl_;
  std::vector<ContactForce> all;
  for (const auto& h : s.stale ? s.pending : s.collect_histories()) {
    const auto sphere_of = [&](std::uint32_t number, std::size_t& body) -> const SphereRow& {
      const auto next =
          std::upper_bound(s.first_sphere_of_rank.begin(), s.first_sphere_of_rank.end(), number);
      const auto rank = static_cast<std::size_t>(next - s.first_sphere_of_rank.begin()) - 1;
      body = s.index_of_rank[rank];
      return s.spheres.row[s.bodies.first[body] + (number - s.first_sphere_of_rank[rank])];
    };
    std::size_t body_a = 0;
    std::size_t body_b = 0;
    const SphereRow& a = sphere_of(h.a, body_a);
    const SphereRow& b = sphere_of(h.b, body_b);
    Eigen::Vector3d between(a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]);
    for (int k = 0; k < 2; ++k)
      between[k] -= s.period.length[k] * std::round(between[k] * s.period.inverse[k]);
    const double distance = between.norm();
    const Eigen::Vector3d normal = between / distance;
    const std::uint32_t pair = law_index(s.bodies.material[body_a], s.bodies.material[body_b]);
    const double stiffness =
        s.coefficients->normal_stiffness(s.bodies.material[body_a], s.bodies.stiffness[body_a], a.radius,
                                         s.bodies.material[body_b], s.bodies.stiffness[body_b], b.radius);
    const double overlap = h.overlap;
    const double radius =
        static_cast<double>(a.radius) * b.radius / (static_cast<double>(a.radius) + b.radius);
    const double shear_stiffness = 1.5 * s.laws.shear_ratio[pair] * stiffness * std::sqrt(overlap);
    ContactForce contact;
    contact.sphere_a = h.a;
    contact.sphere_b = h.b;
    contact.overlap = overlap;
    contact.point = Eigen::Vector3d(a.x[0], a.x[1], a.x[2]) - (a.radius - 0.5 * overlap) * normal;
    contact.force_on_a =
        (stiffness * std::pow(overlap, 1.5) - 2.0 * M_PI * s.laws.cohesion[pair] * radius * overlap) *
            normal -
        shear_stiffness * Eigen::Vector3d(h.shear[0], h.shear[1], h.shear[2]);
    all.push_back(contact);
  }
  return all;
}

std::size_t System::Impl::memory() const {
  std::size_t sum = walls.bytes();
  const auto add = [&](const auto& column) { sum += column.capacity() * sizeof(column[0]); };
  for (int a = 0; a < 3; ++a) {
    add(bodies.x[a]);
    add(bodies.v[a]);
    add(bodies.l[a]);
    add(bodies.inverse_inertia[a]);
  }
  for (const auto& column : bodies.q) add(column);
  add(bodies.inverse_mass);
  for (const auto* column : {&bodies.size, &bodies.stiffness, &bodies.slack, &bodies.reserve, &bodies.reach})
    add(*column);
  add(bodies.rank);
  add(bodies.first);
  add(bodies.shape);
  add(bodies.material);
  add(bodies.asleep);
  add(frozen);
  add(dormant);
  add(bodies.load);
  add(spheres.row);
  add(spheres.body);
  add(index_of_rank);
  add(first_sphere_of_rank);
  for (const auto& part : outer.i) add(part);
  for (const auto& part : outer.j) add(part);
  for (const auto& list : lists) {
    add(list.i);
    add(list.j);
    add(list.source);
    add(list.law);
    for (const auto& column : list.columns) add(column);
  }
  return sum;
}

Statistics System::statistics() const {
  const Impl& s = *impl_;
  Statistics now = s.cost;
  now.contacts = s.touching;
  now.sleeping = s.bodies.count - s.awake_end;
  now.memory_bytes = s.memory();
  // Bodies: centre, velocity, momentum, orientation read and written; properties read; load read, cleared,
  // summed.
  const double body_bytes = 2.0 * (9.0 + (s.only_spheres ? 0.0 : 4.0)) * 8.0 +
                            (s.only_spheres ? 16.0 : 32.0) + 24.0 + 3.0 * sizeof(LoadRow);
  const double sphere_bytes = 2.0 * sizeof(SphereRow) + 4.0;
  const double pair_bytes = 8.0 + 8.0 + 2.0 * 16.0 + (s.law.rolling ? 24.0 : 0.0);
  now.bytes_per_step = body_bytes * static_cast<double>(s.bodies.count) +
                       sphere_bytes * static_cast<double>(s.spheres.count) +
                       pair_bytes * static_cast<double>(s.cost.candidates);
  return now;
}

}  // namespace wheel_twin::dem
