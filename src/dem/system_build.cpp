#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "dem/system_impl.h"

namespace wheel_twin::dem {
namespace {

constexpr double kLargestFraction = 0.5;  ///< of the Rayleigh time

void check_settings(const WorldSettings& s) {
  const auto refuse = [](const std::string& what) { throw Error("world: " + what); };
  if (!s.low.allFinite() || !s.high.allFinite() || !((s.high - s.low).minCoeff() > 0.0)) {
    refuse("the domain has no volume");
  }
  if (!s.gravity.allFinite()) refuse("gravity is not finite");
  if (!(s.time_step >= 0.0) || !std::isfinite(s.time_step))
    refuse(fmt::format("time step {} s", s.time_step));
  if (s.time_step == 0.0 && !(s.step_fraction > 0.0))
    refuse(fmt::format("step fraction {}", s.step_fraction));
  if (s.threads < 1 || s.threads > 256) refuse(fmt::format("{} threads", s.threads));
  if (!(s.smallest_size > 0.0)) refuse(fmt::format("smallest size factor {}", s.smallest_size));
}

double quantum_above(double largest) {
  return std::exp2(std::ceil(std::log2(largest)) - 50.0);
}

}  // namespace

System::Impl::Impl(const WorldSettings& settings_in, const MaterialTable& materials_in,
                   std::vector<ClumpTemplate> templates_in)
    : settings(settings_in), materials(materials_in), templates(std::move(templates_in)) {
  check_settings(settings);
  if (templates.empty()) throw Error("world: no particle template");
  if (settings.particle_materials < 1 || settings.particle_materials > materials.size()) {
    throw Error(
        fmt::format("world: {} particle materials of {}", settings.particle_materials, materials.size()));
  }
  if (templates.size() > 0xffff || materials.size() > 22)
    throw Error("world: too many templates or materials");
  double smallest_radius = 1e300;
  double largest_radius = 0.0;
  double largest_reach = 0.0;
  for (const auto& shape : templates) {
    if (shape.spheres.empty() || shape.spheres.size() > ClumpTemplate::maximum_spheres) {
      throw Error(fmt::format("template '{}': {} spheres", shape.name, shape.spheres.size()));
    }
    only_spheres = only_spheres && shape.spheres.size() == 1;
    for (std::size_t k = 0; k < ClumpTemplate::maximum_spheres; ++k) {
      const ClumpSphere sphere = k < shape.spheres.size() ? shape.spheres[k] : ClumpSphere{};
      shapes.x.push_back(sphere.center.x());
      shapes.y.push_back(sphere.center.y());
      shapes.z.push_back(sphere.center.z());
      shapes.radius.push_back(sphere.radius);
      if (k >= shape.spheres.size()) continue;
      smallest_radius = std::min(smallest_radius, sphere.radius);
      largest_radius = std::max(largest_radius, sphere.radius);
      largest_reach = std::max(largest_reach, sphere.center.norm() + sphere.radius);
    }
    shapes.count.push_back(static_cast<std::uint8_t>(shape.spheres.size()));
    shapes.largest_count = std::max(shapes.largest_count, static_cast<int>(shape.spheres.size()));
  }
  if (templates.size() <= kBatch) {
    const Column<double>* tables[4] = {&shapes.x, &shapes.y, &shapes.z, &shapes.radius};
    for (int c = 0; c < 4; ++c) {
      shapes.few[c].resize(kBatch * ClumpTemplate::maximum_spheres);
      for (std::size_t shape = 0; shape < templates.size(); ++shape) {
        for (std::size_t k = 0; k < ClumpTemplate::maximum_spheres; ++k)
          shapes.few[c][kBatch * k + shape] = (*tables[c])[ClumpTemplate::maximum_spheres * shape + k];
      }
    }
  }
  rayleigh = 1e300;
  for (std::uint32_t m = 0; m < settings.particle_materials; ++m) {
    rayleigh = std::min(rayleigh, rayleigh_time(materials[m], settings.smallest_size * smallest_radius));
  }
  time_step = settings.time_step > 0.0 ? settings.time_step : settings.step_fraction * rayleigh;
  if (time_step > kLargestFraction * rayleigh) {
    throw Error(
        fmt::format("time step {:.3g} s is too large: {:.2f} of the Rayleigh time {:.3g} s, at most {}",
                    time_step, time_step / rayleigh, rayleigh, kLargestFraction));
  }
  for (int a = 0; a < 3; ++a) {
    period.low[a] = settings.low[a];
    period.high[a] = settings.high[a];
    const bool periodic = (a == 0 && settings.periodic_x) || (a == 1 && settings.periodic_y);
    if (!periodic) continue;
    period.length[a] = settings.high[a] - settings.low[a];
    period.inverse[a] = 1.0 / period.length[a];
    if (period.length[a] < 5.0 * largest_reach) {
      throw Error(fmt::format(
          "world: the period {:.3g} m along {} is shorter than five times the largest particle's radius",
          period.length[a], a == 0 ? "x" : "y"));
    }
  }
  double largest_force = 0.0;
  for (std::uint32_t m = 0; m < settings.particle_materials; ++m) {
    for (std::uint32_t n = 0; n < materials.size(); ++n) {
      const double e_eq = 1.0 / (1.0 / materials[m].youngs_modulus() + 1.0 / materials[n].youngs_modulus());
      largest_force = std::max(largest_force, 4.0 * e_eq * largest_radius * largest_radius);
    }
  }
  // 1.5 * 2^52 quanta: adding and subtracting it rounds to whole quanta.
  quanta.force_magic = 1.5 * 0x1.0p52 * quantum_above(largest_force);
  quanta.torque_magic = 1.5 * 0x1.0p52 * quantum_above(largest_force * 2.0 * largest_reach);
  inner_floor = 0.002 * smallest_radius;
  outer_floor = 0.08 * smallest_radius;
  outer_cap = 0.5 * smallest_radius;
  team = std::make_unique<ThreadTeam>(static_cast<std::size_t>(settings.threads));
  prepare_laws();
  cell_size = 4.0 * largest_reach;
  prepare_cells();
  resize(0, 0);
}

void System::Impl::prepare_laws() {
  law = law_of(materials);
  laws = make_law_table(materials);
  coefficients = std::make_unique<PairCoefficients>(materials);
  many_laws = settings.particle_materials > 1;
  // A single particle material has law 0; walls look theirs up.
  coefficients_stale = true;
}

void System::Impl::resize(std::size_t body_count, std::size_t sphere_count) {
  bodies.count = body_count;
  spheres.count = sphere_count;
  const std::size_t padded = (body_count + kBatch - 1) / kBatch * kBatch + kBatch;
  const double middle[3] = {0.5 * (period.low[0] + period.high[0]), 0.5 * (period.low[1] + period.high[1]),
                            0.5 * (period.low[2] + period.high[2])};
  const auto grow = [&](auto& column, auto filler) {
    column.resize(padded, filler);
    std::fill(column.begin() + static_cast<std::ptrdiff_t>(body_count), column.end(), filler);
  };
  for (int a = 0; a < 3; ++a) {
    grow(bodies.x[a], middle[a]);
    grow(bodies.v[a], 0.0);
    grow(bodies.l[a], 0.0);
    if (a == 0 || !only_spheres) grow(bodies.inverse_inertia[a], 0.0);
  }
  if (!only_spheres) {
    for (int a = 0; a < 4; ++a) grow(bodies.q[a], a == 0 ? 1.0 : 0.0);
  }
  grow(bodies.inverse_mass, 0.0);
  grow(bodies.size, 1.0F);
  grow(bodies.stiffness, 1.0F);
  grow(bodies.slack, 1e30F);
  grow(bodies.reserve, 0.0F);
  grow(bodies.reach, 0.0F);
  grow(bodies.rank, 0U);
  grow(bodies.first, 0U);
  grow(bodies.shape, std::uint16_t{0});
  grow(bodies.material, std::uint16_t{0});
  grow(bodies.asleep, std::uint8_t{0});
  grow(bodies.load, LoadRow{});
  spheres.row.resize(sphere_count + 2);
  spheres.body.resize(sphere_count + 2);
  for (std::size_t k = 0; k < 2; ++k) {
    SphereRow dummy{};
    dummy.x[0] = middle[0];
    dummy.x[1] = middle[1];
    dummy.x[2] = 1e6 * static_cast<double>(k + 1);
    dummy.radius = static_cast<float>(inner_floor > 0.0 ? 500.0 * inner_floor : 1e-3);
    spheres.row[sphere_count + k] = dummy;
    spheres.body[sphere_count + k] = static_cast<std::uint32_t>(padded - 1);
  }
}

void System::Impl::set_mass(std::size_t b) {
  const ClumpTemplate& shape = templates[bodies.shape[b]];
  const double size = bodies.size[b];
  const double density = materials[bodies.material[b]].density;
  bodies.inverse_mass[b] = 1.0 / (density * shape.volume * size * size * size);
  const double scale = density * std::pow(size, 5.0);
  for (int a = 0; a < (only_spheres ? 1 : 3); ++a)
    bodies.inverse_inertia[a][b] = 1.0 / (scale * shape.inertia[a]);
  double reach = 0.0;
  for (const auto& sphere : shape.spheres) reach = std::max(reach, sphere.center.norm());
  bodies.reach[b] = static_cast<float>(1.0001 * reach * size);
}

void System::Impl::check_new(const std::vector<Particle>& particles) const {
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const Particle& p = particles[k];
    const auto refuse = [&](const std::string& what) {
      throw Error(fmt::format("step {}: new particle {}: {}", step, bodies.count + k, what));
    };
    if (!p.position.allFinite() || !p.orientation.coeffs().allFinite() || !p.velocity.allFinite() ||
        !p.angular_velocity.allFinite() || !std::isfinite(p.size) || !std::isfinite(p.stiffness)) {
      refuse("a value is not finite");
    }
    if (p.shape >= templates.size()) refuse(fmt::format("template {} of {}", p.shape, templates.size()));
    if (p.material >= settings.particle_materials)
      refuse(fmt::format("material {} is not a particle material", p.material));
    if (!(p.size >= settings.smallest_size * (1.0 - 1e-6))) {
      refuse(fmt::format("size {:.4g} is smaller than the declared smallest {:.4g}", p.size,
                         settings.smallest_size));
    }
    if (!(p.stiffness > 0.0)) refuse(fmt::format("stiffness factor {}", p.stiffness));
    if (time_step > kLargestFraction * rayleigh / std::sqrt(std::max(p.stiffness, 1.0))) {
      refuse(
          fmt::format("time step {:.3g} s is too large for stiffness factor {:.3g}", time_step, p.stiffness));
    }
    if (std::fabs(p.orientation.norm() - 1.0) > 1e-6) refuse("the orientation is not a unit quaternion");
    for (int a = 0; a < 3; ++a) {
      if (p.position[a] < period.low[a] || p.position[a] > period.high[a]) {
        refuse(fmt::format("at ({:.4g}, {:.4g}, {:.4g}) m is outside the domain", p.position.x(),
                           p.position.y(), p.position.z()));
      }
    }
  }
}

void System::Impl::append(const std::vector<Particle>& particles) {
  check_new(particles);
  wake_all();
  pending = stale ? pending : collect_histories();
  dormant.clear();
  const std::size_t first = bodies.count;
  std::size_t next_sphere = spheres.count;
  std::size_t total = spheres.count;
  for (const auto& p : particles) total += shapes.count[p.shape];
  const auto touches = walls.take_touches();
  resize(first + particles.size(), total);
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const Particle& p = particles[k];
    const std::size_t b = first + k;
    bodies.shape[b] = static_cast<std::uint16_t>(p.shape);
    bodies.material[b] = static_cast<std::uint16_t>(p.material);
    bodies.size[b] = static_cast<float>(p.size);
    bodies.stiffness[b] = static_cast<float>(p.stiffness);
    bodies.rank[b] = static_cast<std::uint32_t>(b);
    bodies.first[b] = static_cast<std::uint32_t>(next_sphere);
    for (std::uint32_t s = 0; s < shapes.count[p.shape]; ++s) {
      spheres.body[next_sphere++] = static_cast<std::uint32_t>(b);
    }
    set_mass(b);
    const Eigen::Quaterniond q = p.orientation.normalized();
    if (!only_spheres) {
      bodies.q[0][b] = q.w();
      bodies.q[1][b] = q.x();
      bodies.q[2][b] = q.y();
      bodies.q[3][b] = q.z();
    }
    const Eigen::Vector3d momentum = momentum_of(b, p.angular_velocity);
    // Velocities are kept at half steps: half a step back under gravity alone.
    const Eigen::Vector3d velocity = p.velocity - 0.5 * time_step * settings.gravity;
    for (int a = 0; a < 3; ++a) {
      bodies.x[a][b] = p.position[a];
      bodies.v[a][b] = velocity[a];
      bodies.l[a][b] = momentum[a];
    }
  }
  awake_end = bodies.count;
  renumber();
  walls.put_touches(touches, spheres, bounds);
  stale = true;
  place_spheres(motion_task(), 0, bodies.load.size() - kBatch);
}

void System::Impl::renumber() {
  index_of_rank.resize(bodies.count);
  first_sphere_of_rank.assign(bodies.count + 1, 0);
  for (std::size_t b = 0; b < bodies.count; ++b)
    index_of_rank[bodies.rank[b]] = static_cast<std::uint32_t>(b);
  for (std::size_t r = 0; r < bodies.count; ++r) {
    first_sphere_of_rank[r + 1] = first_sphere_of_rank[r] + shapes.count[bodies.shape[index_of_rank[r]]];
  }
  const std::size_t threads = team->size();
  bounds.assign(threads + 1, 0);
  std::size_t awake_spheres = 0;
  for (std::size_t b = 0; b < awake_end; ++b) awake_spheres += shapes.count[bodies.shape[b]];
  for (std::size_t t = 1; t < threads; ++t) {
    const std::size_t target = awake_spheres * t / threads;
    std::size_t b = 0;
    std::size_t sum = 0;
    while (b < awake_end && sum < target) sum += shapes.count[bodies.shape[b++]];
    bounds[t] = std::max(bounds[t - 1], b / kBatch * kBatch);
  }
  bounds[threads] = awake_end;
  if (settings.sleep.enabled) bounds.push_back(bodies.count);
}

void System::Impl::check_overlaps(std::size_t first_new) {
  std::fill(bodies.reserve.begin(), bodies.reserve.end(), 0.0F);
  OuterList found;
  find_pairs(bodies, spheres, period, bounds, found);
  const auto position = [&](std::uint32_t s) {
    return Eigen::Vector3d(spheres.row[s].x[0], spheres.row[s].x[1], spheres.row[s].x[2]);
  };
  for (std::size_t part = 0; part < found.i.size(); ++part) {
    for (std::size_t k = 0; k < found.i[part].size(); ++k) {
      const std::uint32_t i = found.i[part][k];
      const std::uint32_t j = found.j[part][k];
      const std::uint32_t a = bodies.rank[spheres.body[i]];
      const std::uint32_t b = bodies.rank[spheres.body[j]];
      if (std::max(a, b) < first_new) continue;
      Eigen::Vector3d d = position(i) - position(j);
      for (int c = 0; c < 2; ++c) d[c] -= period.length[c] * std::round(d[c] * period.inverse[c]);
      const double smaller = std::min(spheres.row[i].radius, spheres.row[j].radius);
      const double overlap = static_cast<double>(spheres.row[i].radius) + spheres.row[j].radius - d.norm();
      if (overlap > settings.largest_start_overlap * smaller) {
        throw Error(
            fmt::format("step {}: new particle {} overlaps particle {} by {:.3g} m, {:.0f} % of a radius",
                        step, std::max(a, b), std::min(a, b), overlap, 100.0 * overlap / smaller));
      }
    }
  }
  for (const auto& part : walls.parts()) {
    for (const auto& facet : part.facets) {
      for (std::uint32_t s = 0; s < spheres.count; ++s) {
        const std::uint32_t rank = bodies.rank[spheres.body[s]];
        if (rank < first_new) continue;
        const double overlap = spheres.row[s].radius - closest_point(facet, position(s)).distance;
        if (overlap > settings.largest_start_overlap * spheres.row[s].radius) {
          throw Error(fmt::format("step {}: new particle {} overlaps wall '{}' by {:.3g} m", step, rank,
                                  part.wall.name, overlap));
        }
      }
    }
  }
}

void System::Impl::erase(const std::vector<bool>& which) {
  if (which.size() != bodies.count) {
    throw Error(fmt::format("remove: {} entries for {} particles", which.size(), bodies.count));
  }
  wake_all();
  std::vector<ContactHistory> histories = stale ? pending : collect_histories();
  dormant.clear();
  std::vector<WallSet::Touch> touches = walls.take_touches();
  constexpr std::uint32_t kGone = 0xffffffffU;
  std::vector<std::uint32_t> new_rank(bodies.count, kGone);
  std::uint32_t next = 0;
  for (std::size_t r = 0; r < bodies.count; ++r) {
    if (!which[r]) new_rank[r] = next++;
  }
  // Public sphere numbers after the removal.
  std::vector<std::uint32_t> new_sphere(spheres.count, kGone);
  std::uint32_t next_sphere = 0;
  for (std::size_t r = 0; r < bodies.count; ++r) {
    for (std::uint32_t s = first_sphere_of_rank[r]; s < first_sphere_of_rank[r + 1]; ++s) {
      if (!which[r]) new_sphere[s] = next_sphere++;
    }
  }
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> kept_sphere(spheres.count, kGone);
  std::uint32_t place = 0;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    if (which[bodies.rank[b]]) continue;
    order.push_back(static_cast<std::uint32_t>(b));
    for (std::uint32_t s = 0; s < shapes.count[bodies.shape[b]]; ++s)
      kept_sphere[bodies.first[b] + s] = place++;
  }
  bodies.count = order.size();
  permute(bodies, spheres, shapes, order);
  lists.clear();
  for (std::size_t b = 0; b < bodies.count; ++b) bodies.rank[b] = new_rank[bodies.rank[b]];
  resize(order.size(), next_sphere);
  pending.clear();
  for (auto history : histories) {
    history.a = new_sphere[history.a];
    history.b = new_sphere[history.b];
    if (history.a != kGone && history.b != kGone) pending.push_back(history);
  }
  std::vector<WallSet::Touch> kept;
  for (auto touch : touches) {
    touch.sphere = kept_sphere[touch.sphere];
    if (touch.sphere != kGone) kept.push_back(touch);
  }
  awake_end = bodies.count;
  renumber();
  walls.put_touches(kept, spheres, bounds);
  stale = true;
  place_spheres(motion_task(), 0, bodies.load.size() - kBatch);
}

}  // namespace wheel_twin::dem
