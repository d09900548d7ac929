#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>

#include "dem/system_impl.h"

namespace wheel_twin::dem {
namespace {

/// What a body's spheres may move in a step at its present speed, m.
double way_of(const Bodies& bodies, const Spheres& spheres, std::size_t b, double time_step) {
  const SphereRow& row = spheres.row[bodies.first[b]];
  const double v = std::sqrt(row.v[0] * row.v[0] + row.v[1] * row.v[1] + row.v[2] * row.v[2]);
  const double w = std::sqrt(row.w[0] * row.w[0] + row.w[1] * row.w[1] + row.w[2] * row.w[2]);
  return 1.2 * time_step * (v + w * bodies.reach[b]);
}

}  // namespace

void System::Impl::refresh() {
  Stopwatch watch;
  if (!stale) tune();
  if (stale || regroup || !allot()) {
    build_outer();
    allot();
  }
  lists.resize(bounds.size());
  const std::vector<ContactHistory> histories = std::move(pending);
  pending.clear();
  team->run([&](std::size_t t) {
    build_inner(t);
    walls.find_inner(t, bodies, spheres, period, *coefficients);
  });
  build_inner(lists.size() - 1);
  if (!histories.empty()) distribute_histories(histories);
  stale = false;
  coefficients_stale = false;
  last_refresh = step;
  ++cost.list_refreshes;
  cost.seconds_lists += watch.lap();
}

void System::Impl::build_outer() {
  if (!stale) pending = collect_histories();
  // The walls' touches name spheres by place; hold them by number while the bodies move in memory.
  std::vector<WallSet::Touch> touches = walls.take_touches();
  for (auto& touch : touches) touch.sphere = number_of(touch.sphere);
  const double cell = 2.0 * outer_cap;  // about a sphere's radius
  permute(bodies, spheres, shapes, spatial_order(bodies, period, 3.0 * cell));
  awake_end = static_cast<std::size_t>(
      std::find(bodies.asleep.begin(), bodies.asleep.begin() + static_cast<std::ptrdiff_t>(bodies.count), 1) -
      bodies.asleep.begin());
  renumber();
  place_spheres(motion_task(), 0, bodies.load.size() - kBatch);
  std::vector<std::uint32_t> place_of(spheres.count);
  for (std::uint32_t s = 0; s < spheres.count; ++s) place_of[number_of(s)] = s;
  for (auto& touch : touches) touch.sphere = place_of[touch.sphere];

  for (std::size_t b = 0; b < bodies.count; ++b) {
    const double way = way_of(bodies, spheres, b, time_step);
    bodies.reserve[b] =
        static_cast<float>(std::min(outer_floor + outer_steps * way, outer_cap + inner_steps * way));
    bodies.slack[b] = 0.0F;
  }
  walls.refill(time_step, static_cast<int>(outer_steps), outer_floor);
  const std::size_t sleepers = settings.sleep.enabled ? team->size() : ~std::size_t{0};
  find_pairs(bodies, spheres, period, bounds, outer, sleepers);
  walls.find_outer(bodies, spheres, period, bounds);
  walls.put_touches(std::move(touches), spheres, bounds);
  lists.assign(bounds.size(), {});
  if (settings.sleep.enabled) {
    part_dormant(place_of);
    freeze(place_of);
  }
  regroup = false;
  ++cost.list_builds;
}

bool System::Impl::allot() {
  bool enough = true;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    const double wanted = inner_floor + inner_steps * way_of(bodies, spheres, b, time_step);
    const double whole = static_cast<double>(bodies.reserve[b]) + bodies.slack[b];
    const auto slack = static_cast<float>(std::min(wanted, whole));
    bodies.slack[b] = slack;
    // Rounded down, so that the parts never exceed the whole.
    bodies.reserve[b] = static_cast<float>((whole - slack) * (1.0 - 1e-6));
    if (slack < 0.5 * wanted) enough = false;
  }
  return walls.allot(time_step, static_cast<int>(inner_steps), inner_floor) && enough;
}

void System::Impl::build_inner(std::size_t part) {
  PairList& list = lists[part];
  const auto& outer_i = outer.i[part];
  const auto& outer_j = outer.j[part];
  constexpr std::uint32_t kNew = 0xffffffffU;
  constexpr std::uint32_t ahead = 16;
  const std::size_t guess = list.size + list.size / 16 + 64;
  Column<std::uint32_t> next_i;
  Column<std::uint32_t> next_j;
  Column<std::uint32_t> source;
  std::vector<std::uint32_t> from;
  next_i.reserve(guess);
  next_j.reserve(guess);
  source.reserve(guess);
  from.reserve(guess);
  std::size_t old = 0;
  for (std::uint32_t k = 0; k < outer_i.size(); ++k) {
    if (k + ahead < outer_i.size()) {
      hwy::Prefetch(spheres.row.data() + outer_i[k + ahead]);
      hwy::Prefetch(spheres.row.data() + outer_j[k + ahead]);
    }
    const SphereRow& a = spheres.row[outer_i[k]];
    const SphereRow& b = spheres.row[outer_j[k]];
    double dx = a.x[0] - b.x[0];
    double dy = a.x[1] - b.x[1];
    const double dz = a.x[2] - b.x[2];
    dx -= period.length[0] * std::nearbyint(dx * period.inverse[0]);
    dy -= period.length[1] * std::nearbyint(dy * period.inverse[1]);
    const double reach = static_cast<double>(a.radius) + b.radius + bodies.slack[spheres.body[outer_i[k]]] +
                         bodies.slack[spheres.body[outer_j[k]]];
    if (dx * dx + dy * dy + dz * dz >= reach * reach) continue;
    while (old < list.size && list.source[old] < k) ++old;
    next_i.push_back(outer_i[k]);
    next_j.push_back(outer_j[k]);
    source.push_back(k);
    from.push_back(old < list.size && list.source[old] == k ? static_cast<std::uint32_t>(old) : kNew);
  }
  while (next_i.size() % kBatch != 0) {
    next_i.push_back(static_cast<std::uint32_t>(spheres.count));
    next_j.push_back(static_cast<std::uint32_t>(spheres.count + 1));
    source.push_back(kNew);
    from.push_back(kNew);
  }
  list.size = next_i.size();
  list.i = std::move(next_i);
  list.j = std::move(next_j);
  list.source = std::move(source);
  // One column after the other, so that only one is held twice.
  for (int c = 0; c < PairList::kColumns; ++c) {
    if (c >= PairList::kRolling && !law.rolling) continue;
    const bool renew = c <= PairList::kDamping && coefficients_stale;
    Column<float> column(list.size);
    for (std::size_t n = 0; n < list.size; ++n) {
      column[n] =
          from[n] == kNew || renew || list.columns[c].size() <= from[n] ? 0.0F : list.columns[c][from[n]];
    }
    list.columns[c] = std::move(column);
  }
  list.law.resize(many_laws ? list.size : 0);
  for (std::size_t n = 0; n < list.size; ++n) {
    if (list.source[n] == kNew) continue;
    const std::uint32_t a = spheres.body[list.i[n]];
    const std::uint32_t b = spheres.body[list.j[n]];
    if (many_laws) list.law[n] = static_cast<std::uint8_t>(law_index(bodies.material[a], bodies.material[b]));
    if (list.columns[PairList::kStiffness][n] != 0.0F) continue;
    list.columns[PairList::kStiffness][n] = coefficients->normal_stiffness(
        bodies.material[a], bodies.stiffness[a], spheres.row[list.i[n]].radius, bodies.material[b],
        bodies.stiffness[b], spheres.row[list.j[n]].radius);
    list.columns[PairList::kDamping][n] = coefficients->damping(bodies.material[a], bodies.inverse_mass[a],
                                                                bodies.material[b], bodies.inverse_mass[b]);
  }
}

void System::Impl::tune() {
  // A list that lasts n steps costs its making over n; every step of skin adds candidates in proportion. The
  // best n is where the two are equal. Counted, not timed: what a run does is the same on a busy machine.
  constexpr double kPairsAVisit = 6.0;  // an outer pair in a list's making over a candidate in a step
  if (cost.list_refreshes < 4 || cost.candidates == 0) return;
  std::size_t visited = 0;
  for (const auto& part : outer.i) visited += part.size();
  const double lasted = std::max<double>(1.0, static_cast<double>(step - last_refresh));
  const double idle = static_cast<double>(cost.candidates) - static_cast<double>(touching);
  const double growth = std::max(1.0, idle) / lasted;
  const double best = std::sqrt(kPairsAVisit * static_cast<double>(visited) / growth);
  inner_steps = std::clamp(0.8 * inner_steps + 0.2 * best, 8.0, 100.0);
}

std::vector<ContactHistory> System::Impl::collect_histories() const {
  std::vector<ContactHistory> histories;
  for (const auto& list : lists) {
    for (std::size_t n = 0; n < list.size; ++n) {
      const float overlap = list.columns[PairList::kOverlap][n];
      if (overlap == 0.0F) continue;
      ContactHistory h;
      h.a = number_of(list.i[n]);
      h.b = number_of(list.j[n]);
      const float sign = h.a < h.b ? 1.0F : -1.0F;
      if (h.a > h.b) std::swap(h.a, h.b);
      h.overlap = overlap;
      for (int c = 0; c < 3; ++c) {
        h.shear[c] = sign * list.columns[PairList::kShear + c][n];
        if (law.rolling) h.rolling[c] = sign * list.columns[PairList::kRolling + c][n];
      }
      histories.push_back(h);
    }
  }
  histories.insert(histories.end(), dormant.begin(), dormant.end());
  std::sort(histories.begin(), histories.end(), [](const ContactHistory& p, const ContactHistory& q) {
    return p.a != q.a ? p.a < q.a : p.b < q.b;
  });
  return histories;
}

void System::Impl::distribute_histories(const std::vector<ContactHistory>& histories) {
  std::vector<std::uint32_t> start(spheres.count + 1, 0);
  for (const auto& h : histories) ++start[h.a + 1];
  for (std::size_t s = 0; s < spheres.count; ++s) start[s + 1] += start[s];
  for (auto& list : lists) {
    for (std::size_t n = 0; n < list.size; ++n) {
      if (list.i[n] >= spheres.count) continue;
      std::uint32_t a = number_of(list.i[n]);
      std::uint32_t b = number_of(list.j[n]);
      const float sign = a < b ? 1.0F : -1.0F;
      if (a > b) std::swap(a, b);
      for (std::uint32_t k = start[a]; k < start[a + 1]; ++k) {
        if (histories[k].b != b) continue;
        list.columns[PairList::kOverlap][n] = histories[k].overlap;
        for (int c = 0; c < 3; ++c) {
          list.columns[PairList::kShear + c][n] = sign * histories[k].shear[c];
          if (law.rolling) list.columns[PairList::kRolling + c][n] = sign * histories[k].rolling[c];
        }
      }
    }
  }
}

}  // namespace wheel_twin::dem
