#include "dem/wall_set.h"

#include <fmt/format.h>

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

constexpr double kSamePlace = 0.02;  ///< of the radius: two closest points that are one contact

/// The image of `x` that is nearest to `center` on the periodic axes.
Eigen::Vector3d image_near(const Eigen::Vector3d& x, const Eigen::Vector3d& center, const Period& period) {
  Eigen::Vector3d y = x;
  for (int a = 0; a < 2; ++a) y[a] -= period.length[a] * std::round((x[a] - center[a]) * period.inverse[a]);
  return y;
}

/// Where on the periodic axes a face is: the middle of its bounds (the nearest image of a point to it lies
/// within the bounds of a face as long as the period, which the centroid does not give), for half-spaces the
/// sphere itself.
Eigen::Vector3d middle_of(const Facet& facet, const Eigen::Vector3d& fallback) {
  switch (facet.kind) {
    case Facet::Kind::kTriangle:
      return 0.5 *
             (facet.a.cwiseMin(facet.b).cwiseMin(facet.c) + facet.a.cwiseMax(facet.b).cwiseMax(facet.c));
    case Facet::Kind::kRing:
      return facet.a + 0.5 * (facet.h0 + facet.h1) * facet.b;
    default:
      return fallback;
  }
}

/// Box around faces.
struct Bounds {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e30);
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-1e30);

  Bounds() = default;
  explicit Bounds(const std::vector<Facet>& facets) {
    for (const auto& facet : facets) {
      Eigen::Vector3d from;
      Eigen::Vector3d to;
      bounds_of(facet, from, to);
      low = low.cwiseMin(from);
      high = high.cwiseMax(to);
    }
  }
  void add(const Bounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  /// Largest distance along an axis of the nearest image of `x`, m: no face is nearer.
  double distance(const Eigen::Vector3d& x, const Period& period) const {
    const Eigen::Vector3d middle = 0.5 * (low + high);
    return ((image_near(x, middle, period) - middle).cwiseAbs() - 0.5 * (high - low)).maxCoeff();
  }
};

Eigen::Vector3d center_of(const SphereRow& row) {
  return {row.x[0], row.x[1], row.x[2]};
}

void check_finite(const std::string& name, const Pose& pose, const Motion& motion) {
  if (pose.position.allFinite() && pose.orientation.coeffs().allFinite() && motion.velocity.allFinite() &&
      motion.angular_velocity.allFinite())
    return;
  throw Error(fmt::format("wall '{}': pose or motion is not finite", name));
}

double rotated_distance(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double radius) {
  return a.angularDistance(b) * radius;
}

}  // namespace

struct WallSet::Found {
  const Candidate* candidate;
  ClosestPoint closest;
};

std::uint32_t WallSet::add(const Wall& wall) {
  check_finite(wall.name, wall.pose, wall.motion);
  Part part;
  part.wall = wall;
  part.wall.pose.orientation.normalize();
  part.facets = make_facets(part.wall);
  measure(part);
  parts_.push_back(std::move(part));
  return static_cast<std::uint32_t>(parts_.size() - 1);
}

void WallSet::measure(Part& part) const {
  part.radius = 0.0;
  const Eigen::Vector3d& origin = part.wall.pose.position;
  for (const auto& facet : part.facets) {
    if (facet.kind == Facet::Kind::kTriangle) {
      for (const auto* v : {&facet.a, &facet.b, &facet.c})
        part.radius = std::max(part.radius, (*v - origin).norm());
    } else if (facet.kind == Facet::Kind::kRing) {
      part.radius = std::max({part.radius, std::hypot(facet.r0, facet.h0), std::hypot(facet.r1, facet.h1)});
    } else {
      part.radius = 2.0;
    }
  }
}

void WallSet::remove(std::uint32_t wall) {
  parts_.at(wall).removed = true;
  parts_[wall].facets.clear();
}

void WallSet::set_pose(std::uint32_t wall, const Pose& pose, const Motion& motion) {
  Part& part = parts_.at(wall);
  check_finite(part.wall.name, pose, motion);
  part.slack -= (pose.position - part.wall.pose.position).norm() +
                rotated_distance(pose.orientation, part.wall.pose.orientation, part.radius);
  part.wall.pose = pose;
  part.wall.pose.orientation.normalize();
  part.wall.motion = motion;
  part.placed = part.moved = true;
  place_facets(part.wall, part.facets);
}

void WallSet::set_motion(std::uint32_t wall, const Motion& motion) {
  Part& part = parts_.at(wall);
  check_finite(part.wall.name, part.wall.pose, motion);
  part.wall.motion = motion;
}

void WallSet::set_mesh(std::uint32_t wall, const Mesh& mesh) {
  Part& part = parts_.at(wall);
  const auto* old = std::get_if<Mesh>(&part.wall.shape);
  if (old == nullptr || old->vertices.size() != mesh.vertices.size() || old->triangles != mesh.triangles) {
    throw Error(fmt::format("wall '{}': a new shape must have the old one's faces", part.wall.name));
  }
  double way = 0.0;
  for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
    if (!mesh.vertices[k].allFinite())
      throw Error(fmt::format("wall '{}': vertex {} is not finite", part.wall.name, k));
    way = std::max(way, (mesh.vertices[k] - old->vertices[k]).norm());
  }
  part.slack -= way;
  part.wall.shape = mesh;
  part.moved = true;
  place_facets(part.wall, part.facets);
  measure(part);
}

double WallSet::advance(double time_step) {
  double smallest = 1e30;
  for (auto& part : parts_) {
    if (part.removed) continue;
    const Motion& motion = part.wall.motion;
    if (part.placed) {
      part.placed = false;
    } else if (part.moves()) {
      part.moved = true;
      part.wall.pose.position += time_step * motion.velocity;
      const double angle = motion.angular_velocity.norm() * time_step;
      if (angle > 0.0) {
        const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, motion.angular_velocity.normalized()));
        part.wall.pose.orientation = (turn * part.wall.pose.orientation).normalized();
      }
      part.slack -= motion.velocity.norm() * time_step + angle * part.radius;
      place_facets(part.wall, part.facets);
    }
    smallest = std::min(smallest, part.slack);
  }
  return smallest;
}

bool WallSet::allot(double time_step, int steps, double least) {
  bool enough = true;
  for (auto& part : parts_) {
    if (part.removed) continue;
    const double speed =
        part.wall.motion.velocity.norm() + part.wall.motion.angular_velocity.norm() * part.radius;
    part.reserve += part.slack;
    const double wanted = least + 1.2 * speed * time_step * steps;
    part.slack = std::min(wanted, part.reserve);
    part.reserve -= part.slack;
    if (part.slack < 0.5 * wanted) enough = false;
  }
  return enough;
}

void WallSet::refill(double time_step, int steps, double least) {
  for (auto& part : parts_) {
    const double speed =
        part.wall.motion.velocity.norm() + part.wall.motion.angular_velocity.norm() * part.radius;
    part.reserve = least + 1.2 * speed * time_step * steps;
    part.slack = 0.0;
  }
}

std::uint32_t WallSet::surface_of(std::uint32_t part) const {
  const std::int32_t surface = parts_[part].wall.surface;
  return surface < 0 ? part : 0x80000000U + static_cast<std::uint32_t>(surface);
}

std::vector<bool> WallSet::near_moved(const std::vector<Eigen::Vector3d>& points, double range,
                                      const Period& period) {
  std::vector<bool> near(points.size(), false);
  for (auto& part : parts_) {
    if (!part.moved || part.facets.empty()) continue;
    part.moved = false;
    const Bounds box(part.facets);
    for (std::size_t k = 0; k < points.size(); ++k)
      near[k] = near[k] || box.distance(points[k], period) < range;
  }
  return near;
}

void WallSet::find_outer(const Bodies& bodies, const Spheres& spheres, const Period& period,
                         const ThreadBounds& bounds) {
  const std::size_t threads = bounds.size() - 1;
  threads_.resize(threads);
  for (auto& thread : threads_) thread.outer.clear();
  // From the whole of a surface to its parts to their faces: most spheres are far from all of them.
  std::map<std::uint32_t, std::vector<std::uint32_t>> surfaces;
  for (std::uint32_t p = 0; p < parts_.size(); ++p) {
    if (!parts_[p].facets.empty()) surfaces[surface_of(p)].push_back(p);
  }
  std::vector<std::uint32_t> near_surface;
  std::vector<std::uint32_t> near_part;
  const auto skin_of = [&](std::uint32_t s) {
    return spheres.row[s].radius + bodies.reserve[spheres.body[s]];
  };
  for (const auto& [surface, members] : surfaces) {
    Bounds whole;
    double reserve = 0.0;
    for (const auto p : members) {
      whole.add(Bounds(parts_[p].facets));
      reserve = std::max(reserve, parts_[p].reserve);
    }
    for (std::size_t t = 0; t < threads; ++t) {
      near_surface.clear();
      for (std::size_t b = bounds[t]; b < bounds[t + 1]; ++b) {
        const std::uint32_t end =
            b + 1 < bodies.count ? bodies.first[b + 1] : static_cast<std::uint32_t>(spheres.count);
        for (std::uint32_t s = bodies.first[b]; s < end; ++s) {
          if (whole.distance(center_of(spheres.row[s]), period) < skin_of(s) + reserve)
            near_surface.push_back(s);
        }
      }
      for (const auto p : members) {
        const Part& part = parts_[p];
        const Bounds box(part.facets);
        near_part.clear();
        for (const auto s : near_surface) {
          if (box.distance(center_of(spheres.row[s]), period) < skin_of(s) + part.reserve)
            near_part.push_back(s);
        }
        for (std::uint32_t f = 0; f < part.facets.size(); ++f) {
          for (const auto s : near_part) {
            const Eigen::Vector3d center = center_of(spheres.row[s]);
            const Eigen::Vector3d x = image_near(center, middle_of(part.facets[f], center), period);
            if (closest_point(part.facets[f], x).distance < skin_of(s) + part.reserve)
              threads_[t].outer.push_back({s, surface, p, f, 0.0F, 0.0F, 0});
          }
        }
      }
    }
  }
  for (auto& thread : threads_) {
    std::sort(thread.outer.begin(), thread.outer.end(), [](const Candidate& a, const Candidate& b) {
      return std::tie(a.sphere, a.surface, a.part, a.facet) < std::tie(b.sphere, b.surface, b.part, b.facet);
    });
  }
}

void WallSet::find_inner(std::size_t t, const Bodies& bodies, const Spheres& spheres, const Period& period,
                         const PairCoefficients& coefficients) {
  Thread& thread = threads_[t];
  thread.inner.clear();
  for (const auto& c : thread.outer) {
    const Part& part = parts_[c.part];
    const std::uint32_t b = spheres.body[c.sphere];
    const Facet& facet = part.facets[c.facet];
    const SphereRow& row = spheres.row[c.sphere];
    const Eigen::Vector3d x = image_near(center_of(row), middle_of(facet, center_of(row)), period);
    if (closest_point(facet, x).distance >= row.radius + bodies.slack[b] + part.slack) continue;
    Candidate near = c;
    near.stiffness = coefficients.normal_stiffness(bodies.material[b], bodies.stiffness[b], row.radius,
                                                   part.wall.material, 1.0, 0.0);
    near.damping = coefficients.damping(bodies.material[b], bodies.inverse_mass[b], part.wall.material, 0.0);
    near.law = static_cast<std::uint8_t>(law_index(bodies.material[b], part.wall.material));
    thread.inner.push_back(near);
  }
}

void WallSet::resolve(Thread& thread, std::size_t begin, std::size_t end, const Spheres& spheres,
                      const Period& period, std::vector<Found>& found) const {
  found.clear();
  const SphereRow& row = spheres.row[thread.inner[begin].sphere];
  const Eigen::Vector3d center = center_of(row);
  for (std::size_t k = begin; k < end; ++k) {
    const Candidate& candidate = thread.inner[k];
    const Facet& facet = parts_[candidate.part].facets[candidate.facet];
    const Eigen::Vector3d x = image_near(center, middle_of(facet, center), period);
    ClosestPoint closest = closest_point(facet, x);
    if (closest.distance < row.radius) found.push_back({&candidate, closest});
  }
  if (found.size() < 2) return;
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.closest.distance < b.closest.distance; });
  // A face that was dropped still covers its place: the one that it belongs to stands for it.
  std::size_t kept = 1;
  std::vector<const Candidate*> deeper_ones{found[0].candidate};
  for (std::size_t k = 1; k < found.size(); ++k) {
    bool same = false;
    for (std::size_t m = 0; m < deeper_ones.size() && !same; ++m) {
      const Facet& deeper = parts_[deeper_ones[m]->part].facets[deeper_ones[m]->facet];
      const Eigen::Vector3d x = image_near(found[k].closest.point, middle_of(deeper, center), period);
      same = std::fabs(closest_point(deeper, x).distance) < kSamePlace * row.radius;
    }
    deeper_ones.push_back(found[k].candidate);
    if (!same) found[kept++] = found[k];
  }
  found.resize(kept);
  std::sort(found.begin(), found.end(),
            [](const Found& a, const Found& b) { return a.candidate < b.candidate; });
}

void WallSet::collect(std::size_t t, const Spheres& spheres, const Period& period, bool rolls) {
  Thread& thread = threads_[t];
  thread.before.swap(thread.touches);
  thread.touches.clear();
  thread.point.clear();
  std::vector<Found> found;
  std::vector<bool> passed_on;
  auto& chosen = thread.chosen;
  auto& where = thread.where;
  chosen.clear();
  where.clear();
  std::size_t old = 0;
  constexpr std::size_t ahead = 32;
  for (std::size_t begin = 0; begin < thread.inner.size();) {
    if (begin + ahead < thread.inner.size())
      hwy::Prefetch(spheres.row.data() + thread.inner[begin + ahead].sphere);
    const std::uint32_t sphere = thread.inner[begin].sphere;
    const std::uint32_t surface = thread.inner[begin].surface;
    std::size_t end = begin + 1;
    while (end < thread.inner.size() && thread.inner[end].sphere == sphere &&
           thread.inner[end].surface == surface)
      ++end;
    resolve(thread, begin, end, spheres, period, found);
    const auto key = [&](const Touch& touch) { return std::make_pair(touch.sphere, surface_of(touch.part)); };
    while (old < thread.before.size() && key(thread.before[old]) < std::make_pair(sphere, surface)) ++old;
    std::size_t old_end = old;
    while (old_end < thread.before.size() && key(thread.before[old_end]) == std::make_pair(sphere, surface))
      ++old_end;
    passed_on.assign(old_end - old, false);
    const std::size_t first = thread.touches.size();
    for (const auto& f : found) {
      Touch touch{sphere, f.candidate->part, f.candidate->facet, {}, 0.0F, {}};
      for (std::size_t k = old; k < old_end; ++k) {
        if (thread.before[k].part == touch.part && thread.before[k].facet == touch.facet) {
          touch = thread.before[k];
          passed_on[k - old] = true;
        }
      }
      thread.touches.push_back(touch);
      chosen.push_back(f.candidate);
      where.push_back(f.closest);
    }
    for (std::size_t n = first; n < thread.touches.size(); ++n) {
      Touch& touch = thread.touches[n];
      for (std::size_t k = old; k < old_end && touch.overlap == 0.0F; ++k) {
        if (passed_on[k - old]) continue;
        passed_on[k - old] = true;
        const Candidate& candidate = *chosen[n];
        touch = thread.before[k];
        touch.part = candidate.part;
        touch.facet = candidate.facet;
      }
    }
    old = old_end;
    begin = end;
  }
  WallContacts& contacts = thread.contacts;
  contacts.resize(thread.touches.size(), rolls);
  for (std::size_t k = 0; k < contacts.sphere.size(); ++k) {
    const bool real = k < contacts.size;
    const Candidate* candidate = real ? chosen[k] : nullptr;
    const Part* part = real ? &parts_[candidate->part] : nullptr;
    contacts.sphere[k] = real ? candidate->sphere : static_cast<std::uint32_t>(spheres.count);
    contacts.law[k] = real ? candidate->law : 0;
    contacts.stiffness[k] = real ? candidate->stiffness : 0.0F;
    contacts.damping[k] = real ? candidate->damping : 0.0F;
    contacts.distance[k] = real ? where[k].distance : 1e9;
    contacts.overlap[k] = real ? thread.touches[k].overlap : 0.0F;
    const Eigen::Vector3d speed =
        real ? Eigen::Vector3d(part->wall.motion.velocity + part->wall.motion.angular_velocity.cross(
                                                                where[k].point - part->wall.pose.position))
             : Eigen::Vector3d::Zero();
    for (int a = 0; a < 3; ++a) {
      contacts.normal[a][k] = real ? where[k].normal[a] : 0.0;
      contacts.velocity[a][k] = static_cast<float>(speed[a]);
      contacts.spin[a][k] = real ? static_cast<float>(part->wall.motion.angular_velocity[a]) : 0.0F;
      contacts.shear[a][k] = real ? thread.touches[k].shear[a] : 0.0F;
      if (rolls) contacts.rolling[a][k] = real ? thread.touches[k].rolling[a] : 0.0F;
    }
    if (real) thread.point.push_back(where[k].point);
  }
}

void WallSet::finish(std::size_t t, const Quanta& quanta, bool rolls) {
  Thread& thread = threads_[t];
  thread.wrench.assign(6 * parts_.size(), 0.0);
  const WallContacts& contacts = thread.contacts;
  // The sum over a wall is larger than that on a particle: a coarser quantum, still exact in any order.
  const double force_magic = 1024.0 * quanta.force_magic;
  const double torque_magic = 1024.0 * quanta.torque_magic;
  for (std::size_t k = 0; k < contacts.size; ++k) {
    Touch& touch = thread.touches[k];
    const Part& part = parts_[touch.part];
    const Eigen::Vector3d force{-contacts.force[0][k], -contacts.force[1][k], -contacts.force[2][k]};
    Eigen::Vector3d torque = (thread.point[k] - part.wall.pose.position).cross(force);
    for (int a = 0; a < 3 && rolls; ++a) torque[a] -= contacts.moment[a][k];
    double* sum = &thread.wrench[6 * static_cast<std::size_t>(touch.part)];
    for (int a = 0; a < 3; ++a) {
      sum[a] += (force[a] + force_magic) - force_magic;
      sum[3 + a] += (torque[a] + torque_magic) - torque_magic;
      touch.shear[a] = contacts.shear[a][k];
      if (rolls) touch.rolling[a] = contacts.rolling[a][k];
    }
    touch.overlap = contacts.overlap[k];
  }
}

void WallSet::sum_wrenches() {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    double sum[6] = {};
    for (const auto& thread : threads_) {
      if (thread.wrench.size() < 6 * (p + 1)) continue;
      for (int a = 0; a < 6; ++a) sum[a] += thread.wrench[6 * p + a];
    }
    std::copy(sum, sum + 6, parts_[p].wrench);
  }
}

std::vector<WallSet::Touch> WallSet::take_touches() {
  std::vector<Touch> all;
  for (auto& thread : threads_) {
    all.insert(all.end(), thread.touches.begin(), thread.touches.end());
    thread.touches.clear();
    thread.before.clear();
  }
  return all;
}

void WallSet::put_touches(std::vector<Touch> touches, const Spheres& spheres, const ThreadBounds& bounds) {
  threads_.resize(bounds.size() - 1);
  for (auto& thread : threads_) thread.touches.clear();
  std::sort(touches.begin(), touches.end(), [&](const Touch& a, const Touch& b) {
    return std::make_tuple(a.sphere, surface_of(a.part), a.part, a.facet) <
           std::make_tuple(b.sphere, surface_of(b.part), b.part, b.facet);
  });
  for (const auto& touch : touches) {
    if (parts_[touch.part].removed) continue;
    std::size_t t = 0;
    while (spheres.body[touch.sphere] >= bounds[t + 1]) ++t;
    threads_[t].touches.push_back(touch);
  }
}

std::size_t WallSet::bytes() const {
  std::size_t sum = 0;
  for (const auto& thread : threads_) {
    sum += (thread.outer.capacity() + thread.inner.capacity()) * sizeof(Candidate) +
           (thread.touches.capacity() + thread.before.capacity()) * sizeof(Touch);
  }
  return sum;
}

}  // namespace wheel_twin::dem
