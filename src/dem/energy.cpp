#include <algorithm>
#include <cmath>

#include "dem/system_impl.h"

namespace wheel_twin::dem {
namespace {

Eigen::Vector3d column_vector(const float* trace, std::size_t stride, int first) {
  return {trace[first * stride], trace[(first + 1) * stride], trace[(first + 2) * stride]};
}

Eigen::Vector3d tangential_force(const float* trace, std::size_t stride) {
  const Eigen::Vector3d force = column_vector(trace, stride, Trace::kForce);
  const Eigen::Vector3d normal = column_vector(trace, stride, Trace::kNormal);
  return force - force.dot(normal) * normal;
}

}  // namespace

void LossBook::record(std::uint64_t key, const float* trace, std::size_t stride, double sign, double stored,
                      double time_step, std::int64_t step) {
  const auto before = entries_.find(key);
  const bool known = before != entries_.end() && before->second.step == step - 1;
  if (!known && column_vector(trace, stride, Trace::kForce).isZero(0.0)) return;
  const Entry old = known ? before->second : Entry{};
  const Eigen::Vector3d velocity = column_vector(trace, stride, Trace::kVelocity);
  const Eigen::Vector3d normal = column_vector(trace, stride, Trace::kNormal);
  Entry now;
  now.tangential = sign * tangential_force(trace, stride);
  now.moment = sign * column_vector(trace, stride, Trace::kMoment);
  now.damping = trace[Trace::kDamping * stride];
  now.stored = stored;
  now.step = step;
  const double work = (now.tangential + old.tangential).dot(sign * velocity) +
                      (now.moment + old.moment).dot(sign * column_vector(trace, stride, Trace::kSpin));
  damped -= 0.5 * (now.damping + old.damping) * velocity.dot(normal) * time_step;
  friction -= 0.5 * work * time_step + (stored - old.stored);
  entries_[key] = now;
}

void LossBook::put_to_rest(std::uint64_t key, const float* trace, std::size_t stride, double sign) {
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return;
  entry->second.tangential = sign * tangential_force(trace, stride);
  entry->second.moment = sign * column_vector(trace, stride, Trace::kMoment);
  entry->second.damping = 0.0;
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

std::uint64_t System::Impl::pair_key(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::uint64_t{a} << 32U | b : std::uint64_t{b} << 32U | a;
}

std::uint64_t System::Impl::wall_key(const WallSet::Touch& touch) const {
  return std::uint64_t{number_of(touch.sphere)} << 32U | 0x80000000U | (touch.part & 0x7ffU) << 20U |
         (touch.facet & 0xfffffU);
}

System::Impl::ContactEnergy System::Impl::energy_of(const PairList& list, std::size_t n) const {
  const auto& c = list.columns;
  const std::uint32_t pair = many_laws ? list.law[n] : 0;
  const double ra = spheres.row[list.i[n]].radius;
  const double rb = spheres.row[list.j[n]].radius;
  std::array<double, 6> springs{};
  for (int k = 0; k < 3; ++k) {
    springs[k] = c[PairList::kShear + k][n];
    if (law.rolling) springs[3 + k] = c[PairList::kRolling + k][n];
  }
  return contact_energy(c[PairList::kStiffness][n], c[PairList::kOverlap][n], ra * rb / (ra + rb), pair,
                        springs);
}

System::Impl::ContactEnergy System::Impl::energy_of(const WallContacts& contacts, std::size_t k) const {
  std::array<double, 6> springs{};
  for (int a = 0; a < 3; ++a) {
    springs[a] = contacts.shear[a][k];
    if (law.rolling) springs[3 + a] = contacts.rolling[a][k];
  }
  return contact_energy(contacts.stiffness[k], contacts.overlap[k], spheres.row[contacts.sphere[k]].radius,
                        contacts.law[k], springs);
}

// Tangential spring: S_t = ratio 1.5 k_n sqrt(d), 1/2 S_t xi^2. Rolling spring: 1/2 k_r angle^2 with k_r =
// 2.25 k_n sqrt(d) (mu_r R)^2. Cohesion: k 2 pi R d is the derivative of k pi R d^2.
System::Impl::ContactEnergy System::Impl::contact_energy(double stiffness, double overlap, double radius,
                                                         std::uint32_t pair,
                                                         const std::array<double, 6>& springs) const {
  const Eigen::Map<const Eigen::Vector3d> shear(springs.data());
  const Eigen::Map<const Eigen::Vector3d> rolling(springs.data() + 3);
  const double root = stiffness * std::sqrt(overlap);
  const double arm = laws.rolling[pair] * radius;
  ContactEnergy energy;
  energy.springs = 0.75 * laws.shear_ratio[pair] * root * shear.squaredNorm() +
                   1.125 * root * arm * arm * rolling.squaredNorm();
  energy.normal = 0.4 * root * overlap * overlap - M_PI * laws.cohesion[pair] * radius * overlap * overlap;
  return energy;
}

void System::Impl::record_losses() {
  for (std::size_t p = 0; p < lists.size(); ++p) {
    const PairList& list = lists[p];
    for (std::size_t n = 0; n < list.size; ++n) {
      if (list.i[n] >= spheres.count) continue;
      const std::uint32_t a = number_of(list.i[n]);
      const std::uint32_t b = number_of(list.j[n]);
      losses.record(pair_key(a, b), traces[p].data() + n, list.size, a < b ? 1.0 : -1.0,
                    energy_of(list, n).springs, time_step, step);
    }
  }
  for (auto& part : walls.parts()) {
    const Motion& motion = part.wall.motion;
    for (int a = 0; a < 3; ++a) {
      losses.wall_work -= 0.5 * time_step *
                          ((part.wrench[a] + part.booked[a]) * motion.velocity[a] +
                           (part.wrench[3 + a] + part.booked[3 + a]) * motion.angular_velocity[a]);
    }
    std::copy(part.wrench, part.wrench + 6, part.booked);
  }
  for (const auto& h : dormant) losses.keep(pair_key(h.a, h.b), step);
  for (std::size_t t = 0; t < walls.threads() && !walls.parts().empty(); ++t) {
    if (t >= team->size()) {
      for (const auto& touch : walls.touches(t)) losses.keep(wall_key(touch), step);
      continue;
    }
    const WallContacts& contacts = walls.contacts(t);
    for (std::size_t k = 0; k < contacts.size; ++k) {
      losses.record(wall_key(walls.touches(t)[k]), walls.trace(t).data() + k, contacts.sphere.size(), 1.0,
                    energy_of(contacts, k).springs, time_step, step);
    }
  }
  losses.forget_old(step);
}

void System::Impl::book_rest(const PairList& list, const Column<float>& trace) {
  for (std::size_t n = 0; n < dormant.size(); ++n)
    losses.put_to_rest(pair_key(dormant[n].a, dormant[n].b), trace.data() + n, list.size, 1.0);
  const std::size_t slot = team->size();
  if (walls.parts().empty()) return;
  const std::size_t stride = walls.contacts(slot).sphere.size();
  for (std::size_t k = 0; k < walls.contacts(slot).size; ++k)
    losses.put_to_rest(wall_key(walls.touches(slot)[k]), walls.trace(slot).data() + k, stride, 1.0);
}

void System::Impl::book_crossings(const std::array<Column<double>, 2>& before) {
  for (int a = 0; a < 2; ++a) {
    const double jump = settings.gravity[a] * period.length[a];
    if (jump == 0.0) continue;
    for (std::size_t b = 0; b < awake_end; ++b) {
      const double crossed = std::round((before[a][b] - bodies.x[a][b]) * period.inverse[a]);
      losses.crossings -= crossed * jump * mass_of(b);
    }
  }
}

double System::Impl::kinetic_energy(std::size_t b) const {
  const Eigen::Vector3d momentum = full_momentum(b);
  return 0.5 * mass_of(b) * full_velocity(b).squaredNorm() + 0.5 * momentum.dot(spin_of(b, momentum));
}

EnergyBook System::energy() const {
  const Impl& s = *impl_;
  EnergyBook book;
  for (std::size_t b = 0; b < s.bodies.count; ++b) {
    const double mass = s.mass_of(b);
    book.kinetic += s.kinetic_energy(b);
    book.potential -=
        mass * s.settings.gravity.dot(Eigen::Vector3d(s.bodies.x[0][b], s.bodies.x[1][b], s.bodies.x[2][b]));
  }
  book.potential += s.losses.crossings;
  const auto add = [&](const Impl::ContactEnergy& contact) {
    book.elastic += contact.normal + contact.springs;
  };
  for (const auto& list : s.lists) {
    for (std::size_t n = 0; n < list.size; ++n) {
      if (list.columns[PairList::kOverlap][n] != 0.0F) add(s.energy_of(list, n));
    }
  }
  if (!s.stale && !s.dormant.empty()) {
    std::vector<std::uint32_t> place_of(s.spheres.count);
    for (std::uint32_t k = 0; k < s.spheres.count; ++k) place_of[s.number_of(k)] = k;
    const PairList resting = s.dormant_list(place_of);
    for (std::size_t n = 0; n < s.dormant.size(); ++n) add(s.energy_of(resting, n));
  }
  for (std::size_t t = 0; t < s.walls.threads() && !s.stale; ++t) {
    const WallContacts& contacts = s.walls.contacts(t);
    for (std::size_t k = 0; k < std::min(contacts.size, s.walls.touches(t).size()); ++k)
      add(s.energy_of(contacts, k));
  }
  book.damped = s.losses.damped;
  book.friction = s.losses.friction;
  book.wall_work = s.losses.wall_work;
  return book;
}

}  // namespace wheel_twin::dem
