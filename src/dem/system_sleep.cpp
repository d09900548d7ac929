// Sleep. The domain is cut into cells two grains wide. A cell whose particles have all been quiet in two
// looks falls asleep unless a cell beside it is loud: its particles keep their places, what they exert on one
// another and on walls is computed once. A look goes over the way since the last one: a grain that trembles
// as waves pass is quiet, one that rolls is not. A cell wakes at a look that finds a cell beside it loud, and
// between looks (every 32 steps) when the force on one of its particles has changed, when a wall moves
// nearby, or when an awake particle enters it. All from numbers that depend neither on threads nor on lists.
// A window (hold_beyond) holds whole slabs of cells asleep, whatever happens in them.
#include <algorithm>
#include <cmath>

#include "dem/system_impl.h"

namespace wheel_twin::dem {
namespace {

constexpr std::uint32_t kAsleep = 0xffffffffU;
constexpr std::int64_t kCheck = 32;  // steps
constexpr std::uint32_t kQuietLooks = 2;
constexpr std::uint8_t kOccupied = 1, kStirs = 2, kWakes = 4, kAwakeInside = 8;

}  // namespace

void System::Impl::prepare_cells() {
  std::size_t count = 1;
  for (int a = 0; a < 3; ++a) {
    const double extent = period.high[a] - period.low[a];
    cells[a] = static_cast<int>(std::clamp(std::floor(extent / cell_size), 1.0, 200.0));
    count *= static_cast<std::size_t>(cells[a]);
  }
  if (!settings.sleep.enabled) count = 0;
  quiet.assign(count, 0U);
  loud.assign(count, 0U);
  held.assign(count, 0U);
  hold.clear();
}

std::size_t System::Impl::cell_of(std::size_t b) const {
  std::size_t cell = 0;
  for (int a = 0; a < 3; ++a) {
    const double place = (bodies.x[a][b] - period.low[a]) / (period.high[a] - period.low[a]) * cells[a];
    cell = cell * static_cast<std::size_t>(cells[a]) +
           static_cast<std::size_t>(std::clamp(static_cast<int>(place), 0, cells[a] - 1));
  }
  return cell;
}

bool System::Impl::loud_nearby(std::size_t cell) const {
  int at[3];
  std::size_t rest = cell;
  for (int a = 2; a >= 0; --a) {
    at[a] = static_cast<int>(rest % static_cast<std::size_t>(cells[a]));
    rest /= static_cast<std::size_t>(cells[a]);
  }
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        const int step_to[3] = {dx, dy, dz};
        std::size_t other = 0;
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
          int k = at[a] + step_to[a];
          if (period.inverse[a] != 0.0) k = (k + cells[a]) % cells[a];
          inside = inside && k >= 0 && k < cells[a];
          other = other * static_cast<std::size_t>(cells[a]) + static_cast<std::size_t>(std::max(k, 0));
        }
        if (inside && (loud[other] & kWakes) != 0) return true;
      }
    }
  }
  return false;
}

void System::Impl::check_sleep() {
  if (step % kCheck != 0 || settings.sleep.speed == 0.0) return;
  const SleepSettings& rule = settings.sleep;
  const std::int64_t checks = std::max(
      std::int64_t{1}, static_cast<std::int64_t>(std::llround(0.5 * rule.time / (kCheck * time_step))));
  const bool looks = step / kCheck % checks == 0;
  const Eigen::Vector3d& gravity = settings.gravity;
  std::fill(loud.begin(), loud.end(), std::uint8_t{0});
  std::vector<std::uint8_t> pushed(quiet.size(), 0);
  looked_at.resize(bodies.count, Eigen::Vector3d::Constant(1e30));  // the first look finds everything fast
  for (std::size_t b = 0; b < bodies.count; ++b) {
    const LoadRow& load = bodies.load[b];
    const double mass = 1.0 / bodies.inverse_mass[b];
    Eigen::Vector3d unbalanced = mass * gravity;
    for (int a = 0; a < 3; ++a) unbalanced[a] += load.force[a];
    const double scale = rule.force * std::max(mass * gravity.norm(), load.pressure);
    const std::size_t cell = cell_of(b);
    if (bodies.asleep[b] != 0) {
      if (unbalanced.norm() > scale) pushed[cell] = 1;
      continue;
    }
    loud[cell] |= kOccupied | kAwakeInside;
    if (!looks) continue;
    double square = 0.0;
    for (int a = 0; a < 3; ++a) {
      double& before = looked_at[bodies.rank[b]][a];
      double way = bodies.x[a][b] - before;
      way -= period.length[a] * std::round(way * period.inverse[a]);
      square += way * way;
      before = bodies.x[a][b];
    }
    const double speed = std::sqrt(square) / (static_cast<double>(checks * kCheck) * time_step);
    if (speed > rule.speed) loud[cell] |= kStirs;
    if (speed > rule.wake_factor * rule.speed) loud[cell] |= kWakes;
  }
  std::vector<Eigen::Vector3d> middles(quiet.size());
  for (std::size_t cell = 0; cell < quiet.size(); ++cell) {
    std::size_t rest = cell;
    for (int a = 2; a >= 0; --a) {
      const auto n = static_cast<std::size_t>(cells[a]);
      const double width = (period.high[a] - period.low[a]) / cells[a];
      middles[cell][a] = period.low[a] + (static_cast<double>(rest % n) + 0.5) * width;
      rest /= n;
    }
  }
  double half = 0.0;
  for (int a = 0; a < 3; ++a) half = std::max(half, 0.5 * (period.high[a] - period.low[a]) / cells[a]);
  const std::vector<bool> near_wall = walls.near_moved(middles, half + cell_size, period);
  bool changed = false;
  for (std::size_t cell = 0; cell < quiet.size(); ++cell) {
    std::uint32_t& count = quiet[cell];
    if (count == kAsleep) {
      if (held[cell] != 0) continue;
      if (pushed[cell] == 0 && !near_wall[cell] && (loud[cell] & kAwakeInside) == 0 &&
          !(looks && loud_nearby(cell)))
        continue;
      count = 0;
      changed = true;
    } else if ((loud[cell] & kOccupied) == 0 || (loud[cell] & kStirs) != 0 || near_wall[cell]) {
      count = 0;
    } else if (looks) {
      count = std::min(count + 1, kQuietLooks);
      if (count < kQuietLooks || loud_nearby(cell)) continue;
      count = kAsleep;
      changed = true;
    }
  }
  if (changed) apply_cells();
}

double System::Impl::way_around(double way) const {
  return way - period.length[0] * std::round(way * period.inverse[0]);
}

/// Every particle sleeps or wakes as its cell does.
void System::Impl::apply_cells() {
  for (std::size_t b = 0; b < bodies.count; ++b) {
    const std::uint8_t sleeps = quiet[cell_of(b)] == kAsleep ? 1 : 0;
    if (sleeps != bodies.asleep[b]) set_asleep(b, sleeps != 0);
  }
  regroup = true;
}

void System::Impl::hold_beyond(double middle, double half_length) {
  const double width = (period.high[0] - period.low[0]) / cells[0];
  if (!hold.empty() && hold[1] == half_length && std::abs(way_around(middle - hold[0])) < 0.5 * width) return;
  hold = {middle, half_length};
  const std::vector<std::uint8_t> before = held;
  mark_held();
  if (held == before) return;
  for (std::size_t cell = 0; cell < quiet.size(); ++cell) {
    if (held[cell] != 0) quiet[cell] = kAsleep;
    if (held[cell] == 0 && before[cell] != 0) quiet[cell] = 0;
  }
  apply_cells();
}

void System::Impl::mark_held() {
  held.assign(quiet.size(), 0U);
  if (hold.empty()) return;
  const double width = (period.high[0] - period.low[0]) / cells[0];
  const std::size_t slab = quiet.size() / static_cast<std::size_t>(cells[0]);
  for (std::size_t cell = 0; cell < quiet.size(); ++cell) {
    const double center = period.low[0] + (static_cast<double>(cell / slab) + 0.5) * width;
    held[cell] = std::abs(way_around(center - hold[0])) > hold[1] ? 1 : 0;
  }
}

void System::Impl::set_asleep(std::size_t b, bool asleep) {
  const double before = kinetic_energy(b);
  bodies.asleep[b] = asleep ? 1 : 0;
  for (int a = 0; a < 3 && asleep; ++a) bodies.v[a][b] = bodies.l[a][b] = 0.0;
  losses.damped += before - kinetic_energy(b);
}

// A wall that sleepers touch starts to move: without them its first steps would do no work.
void System::Impl::wake_pressed() {
  if (!stale && awake_end == bodies.count) return;
  // Stale: the touches do not lie apart yet.
  bool pressed = false;
  for (std::size_t t = stale ? 0 : team->size(); t < walls.threads(); ++t) {
    for (const auto& touch : walls.touches(t)) {
      if (!walls.parts()[touch.part].moves()) continue;
      const std::uint32_t b = spheres.body[touch.sphere];
      if (bodies.asleep[b] == 0 || held[cell_of(b)] != 0) continue;
      quiet[cell_of(b)] = 0;
      pressed = true;
    }
  }
  if (!pressed) return;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    if (bodies.asleep[b] != 0 && quiet[cell_of(b)] != kAsleep) set_asleep(b, false);
  }
  regroup = true;
}

void System::Impl::wake_all() {
  if (!settings.sleep.enabled) return;
  for (std::size_t cell = 0; cell < quiet.size(); ++cell) quiet[cell] = held[cell] != 0 ? kAsleep : 0;
  looked_at.clear();
  for (std::size_t b = 0; b < bodies.count; ++b) {
    if (bodies.asleep[b] == 0 || held[cell_of(b)] != 0) continue;
    set_asleep(b, false);
    regroup = true;
  }
}

void System::Impl::part_dormant(const std::vector<std::uint32_t>& place_of) {
  const auto sleeps = [&](std::uint32_t sphere) {
    return bodies.asleep[spheres.body[place_of[sphere]]] != 0;
  };
  const auto border = std::stable_partition(
      pending.begin(), pending.end(), [&](const ContactHistory& h) { return !(sleeps(h.a) && sleeps(h.b)); });
  dormant.assign(border, pending.end());
  pending.erase(border, pending.end());
  touched_sleepers.clear();
  for (std::size_t b = awake_end; b < std::min(bodies.count, (awake_end + kBatch - 1) / kBatch * kBatch); ++b)
    touched_sleepers.push_back(static_cast<std::uint32_t>(b));
  for (const auto* side : {&outer.i.back(), &outer.j.back()}) {
    for (const auto sphere : *side) {
      if (spheres.body[sphere] >= awake_end) touched_sleepers.push_back(spheres.body[sphere]);
    }
  }
  std::sort(touched_sleepers.begin(), touched_sleepers.end());
  touched_sleepers.erase(std::unique(touched_sleepers.begin(), touched_sleepers.end()),
                         touched_sleepers.end());
}

PairList System::Impl::dormant_list(const std::vector<std::uint32_t>& place_of) const {
  PairList list;
  for (const auto& h : dormant) {
    list.i.push_back(place_of[h.a]);
    list.j.push_back(place_of[h.b]);
  }
  while (list.i.size() % kBatch != 0) {
    list.i.push_back(static_cast<std::uint32_t>(spheres.count));
    list.j.push_back(static_cast<std::uint32_t>(spheres.count + 1));
  }
  list.size = list.i.size();
  for (int c = 0; c < PairList::kColumns; ++c) list.columns[c].assign(list.size, 0.0F);
  list.law.assign(many_laws ? list.size : 0, 0);
  for (std::size_t n = 0; n < dormant.size(); ++n) {
    const std::uint32_t a = spheres.body[list.i[n]];
    const std::uint32_t b = spheres.body[list.j[n]];
    if (many_laws) list.law[n] = static_cast<std::uint8_t>(law_index(bodies.material[a], bodies.material[b]));
    list.columns[PairList::kStiffness][n] = coefficients->normal_stiffness(
        bodies.material[a], bodies.stiffness[a], spheres.row[list.i[n]].radius, bodies.material[b],
        bodies.stiffness[b], spheres.row[list.j[n]].radius);
    list.columns[PairList::kDamping][n] = coefficients->damping(bodies.material[a], bodies.inverse_mass[a],
                                                                bodies.material[b], bodies.inverse_mass[b]);
    list.columns[PairList::kOverlap][n] = dormant[n].overlap;
    for (int c = 0; c < 3; ++c) {
      list.columns[PairList::kShear + c][n] = dormant[n].shear[c];
      list.columns[PairList::kRolling + c][n] = dormant[n].rolling[c];
    }
  }
  return list;
}

// Sleeping bodies have no velocity and keep their places, so that this gives the same bits whenever it is
// done; the histories stay as they were when the bodies fell asleep.
void System::Impl::freeze(const std::vector<std::uint32_t>& place_of) {
  for (std::size_t b = awake_end; b < bodies.count; ++b) bodies.load[b] = LoadRow{};
  PairList list = dormant_list(place_of);
  Column<float> trace;
  evaluate_pairs(contact_task(list, trace), 0, list.size);
  const std::size_t slot = team->size();
  if (!walls.parts().empty()) {
    const std::vector<WallSet::Touch> touches = walls.touches(slot);
    walls.find_inner(slot, bodies, spheres, period, *coefficients);
    evaluate_walls_of(slot);
    if (settings.track_energy) book_rest(list, trace);
    walls.touches(slot) = touches;
  } else if (settings.track_energy) {
    book_rest(list, trace);
  }
  frozen.assign(awake_end < bodies.count ? bodies.count : 0, LoadRow{});
  for (std::size_t b = awake_end; b < bodies.count; ++b) frozen[bodies.rank[b]] = bodies.load[b];
}

void System::Impl::reset_sleepers() {
  for (const auto b : touched_sleepers) bodies.load[b] = frozen[bodies.rank[b]];
}

}  // namespace wheel_twin::dem
