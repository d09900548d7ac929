#include <cmath>

#include "dem/system_impl.h"

namespace wheel_twin::dem {
namespace {

/// Energy in the tangential spring: S_t = ratio 1.5 k_n sqrt(overlap), 1/2 S_t xi^2.
double shear_energy(double stiffness, double shear_ratio, double overlap, double sx, double sy, double sz) {
  return 0.75 * shear_ratio * stiffness * std::sqrt(overlap) * (sx * sx + sy * sy + sz * sz);
}
double normal_energy(double stiffness, double overlap) {
  return 0.4 * stiffness * std::pow(overlap, 2.5);
}

/// Energy in the rolling spring, 1/2 k_r angle^2 with k_r = 2.25 k_n sqrt(overlap) (mu_r R)^2.
double rolling_energy(double stiffness, double overlap, double arm, double ax, double ay, double az) {
  return 1.125 * stiffness * std::sqrt(overlap) * arm * arm * (ax * ax + ay * ay + az * az);
}

}  // namespace

void LossBook::record(std::uint64_t key, const float* trace, std::size_t stride, double stored,
                      double time_step, std::int64_t step) {
  const auto value = [&](int column) { return static_cast<double>(trace[column * stride]); };
  const Eigen::Vector3d velocity(value(Trace::kVelocity), value(Trace::kVelocity + 1),
                                 value(Trace::kVelocity + 2));
  const Eigen::Vector3d force(value(Trace::kForce), value(Trace::kForce + 1), value(Trace::kForce + 2));
  const Eigen::Vector3d normal(value(Trace::kNormal), value(Trace::kNormal + 1), value(Trace::kNormal + 2));
  const double damping = value(Trace::kDamping);
  const Eigen::Vector3d tangential = force - force.dot(normal) * normal;
  const auto before = entries_.find(key);
  const bool known = before != entries_.end() && before->second.step == step - 1;
  if (!known && force.isZero(0.0)) return;
  Entry old;
  if (known) old = before->second;
  const Eigen::Vector3d old_tangential(old.tangential[0], old.tangential[1], old.tangential[2]);
  const double sliding = 0.5 * (tangential + old_tangential).dot(velocity) * time_step;
  damped -= 0.5 * (damping + old.damping) * velocity.dot(normal) * time_step;
  friction -= sliding + (stored - old.stored);
  Entry now;
  now.tangential = {tangential.x(), tangential.y(), tangential.z()};
  now.damping = damping;
  now.stored = stored;
  now.step = step;
  entries_[key] = now;
}

void LossBook::keep(std::uint64_t key, std::int64_t step) {
  const auto entry = entries_.find(key);
  if (entry != entries_.end()) entry->second.step = step;
}

void LossBook::forget_old(std::int64_t step) {
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (entry->second.step == step) {
      ++entry;
      continue;
    }
    // Gone without a last look (out of the lists): what its spring held is lost.
    friction += entry->second.stored;
    entry = entries_.erase(entry);
  }
}

void System::Impl::record_losses() {
  const auto number_of = [&](std::uint32_t sphere) {
    const std::uint32_t b = spheres.body[sphere];
    return static_cast<std::uint64_t>(first_sphere_of_rank[bodies.rank[b]]) + (sphere - bodies.first[b]);
  };
  for (std::size_t p = 0; p < lists.size(); ++p) {
    const PairList& list = lists[p];
    for (std::size_t n = 0; n < list.size; ++n) {
      if (list.i[n] >= spheres.count) continue;
      const std::uint32_t pair = many_laws ? list.law[n] : 0;
      const auto& columns = list.columns;
      const double stored = shear_energy(columns[PairList::kStiffness][n], laws.shear_ratio[pair],
                                         columns[PairList::kOverlap][n], columns[PairList::kShear][n],
                                         columns[PairList::kShear + 1][n], columns[PairList::kShear + 2][n]);
      const std::uint64_t a = number_of(list.i[n]);
      const std::uint64_t b = number_of(list.j[n]);
      losses.record(a < b ? a << 32U | b : b << 32U | a, traces[p].data() + n, list.size, stored, time_step,
                    step);
    }
  }
  double power = 0.0;
  for (const auto& part : walls.parts()) power += part.power;
  losses.wall_work += 0.5 * (power + losses.last_wall_power) * time_step;
  losses.last_wall_power = power;
  for (const auto& h : dormant) losses.keep(std::uint64_t{h.a} << 32U | h.b, step);
  for (std::size_t t = 0; t < walls.threads() && !walls.parts().empty(); ++t) {
    const WallContacts& contacts = walls.contacts(t);
    const std::size_t stride = contacts.sphere.size();
    for (std::size_t k = 0; k < contacts.size; ++k) {
      const auto& touch = walls.touches(t)[k];
      const double stored =
          shear_energy(contacts.stiffness[k], laws.shear_ratio[contacts.law[k]], contacts.overlap[k],
                       contacts.shear[0][k], contacts.shear[1][k], contacts.shear[2][k]);
      const std::uint64_t key = number_of(touch.sphere) << 32U | 0x80000000U | (touch.part & 0x7ffU) << 20U |
                                (touch.facet & 0xfffffU);
      if (t >= team->size()) {
        losses.keep(key, step);
        continue;
      }
      losses.record(key, walls.trace(t).data() + k, stride, stored, time_step, step);
    }
  }
  losses.forget_old(step);
}

EnergyBook System::energy() const {
  const Impl& s = *impl_;
  EnergyBook book;
  for (std::size_t b = 0; b < s.bodies.count; ++b) {
    const double mass = s.mass_of(b);
    const Eigen::Vector3d momentum = s.full_momentum(b);
    book.kinetic +=
        0.5 * mass * s.full_velocity(b).squaredNorm() + 0.5 * momentum.dot(s.spin_of(b, momentum));
    book.potential -=
        mass * s.settings.gravity.dot(Eigen::Vector3d(s.bodies.x[0][b], s.bodies.x[1][b], s.bodies.x[2][b]));
  }
  for (const auto& list : s.lists) {
    for (std::size_t n = 0; n < list.size; ++n) {
      const auto& c = list.columns;
      const double overlap = c[PairList::kOverlap][n];
      if (overlap == 0.0) continue;
      const std::uint32_t pair = s.many_laws ? list.law[n] : 0;
      const double ra = s.spheres.row[list.i[n]].radius;
      const double rb = s.spheres.row[list.j[n]].radius;
      const double radius = ra * rb / (ra + rb);
      book.elastic +=
          normal_energy(c[PairList::kStiffness][n], overlap) +
          shear_energy(c[PairList::kStiffness][n], s.laws.shear_ratio[pair], overlap, c[PairList::kShear][n],
                       c[PairList::kShear + 1][n], c[PairList::kShear + 2][n]) -
          M_PI * s.laws.cohesion[pair] * radius * overlap * overlap;
      if (s.law.rolling) {
        book.elastic += rolling_energy(c[PairList::kStiffness][n], overlap, s.laws.rolling[pair] * radius,
                                       c[PairList::kRolling][n], c[PairList::kRolling + 1][n],
                                       c[PairList::kRolling + 2][n]);
      }
    }
  }
  for (std::size_t t = 0; t < s.walls.threads() && !s.stale; ++t) {
    const WallContacts& contacts = s.walls.contacts(t);
    const auto& touches = s.walls.touches(t);
    for (std::size_t k = 0; k < std::min(contacts.size, touches.size()); ++k) {
      const double overlap = contacts.overlap[k];
      const double radius = s.spheres.row[contacts.sphere[k]].radius;
      book.elastic += normal_energy(contacts.stiffness[k], overlap) +
                      shear_energy(contacts.stiffness[k], s.laws.shear_ratio[contacts.law[k]], overlap,
                                   contacts.shear[0][k], contacts.shear[1][k], contacts.shear[2][k]) -
                      M_PI * s.laws.cohesion[contacts.law[k]] * radius * overlap * overlap;
      if (s.law.rolling) {
        book.elastic +=
            rolling_energy(contacts.stiffness[k], overlap, s.laws.rolling[contacts.law[k]] * radius,
                           contacts.rolling[0][k], contacts.rolling[1][k], contacts.rolling[2][k]);
      }
    }
  }
  book.damped = s.losses.damped;
  book.friction = s.losses.friction;
  book.wall_work = s.losses.wall_work;
  return book;
}

}  // namespace wheel_twin::dem
