#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "dem/system_impl.h"

namespace wheel_twin::dem {

MotionTask System::Impl::motion_task() {
  MotionTask task;
  task.bodies = &bodies;
  task.spheres = &spheres;
  task.shapes = &shapes;
  task.period = &period;
  task.time_step = time_step;
  for (int a = 0; a < 3; ++a) task.gravity[a] = settings.gravity[a];
  task.awake_end = awake_end;
  return task;
}

void System::Impl::step_once() {
  // Who sleeps must be known before anything moves.
  if (settings.sleep.enabled) {
    wake_pressed();
    if (regroup || stale) refresh();
  }
  Stopwatch watch;
  const double wall_slack = walls.advance(time_step);
  const MotionTask motion = motion_task();
  std::vector<MotionResult> moved(team->size());
  const std::size_t padded = (awake_end + kBatch - 1) / kBatch * kBatch;
  if (bounds.size() != team->size() + (settings.sleep.enabled ? 2 : 1)) {
    stale = stale || (pending = collect_histories(), true);
    renumber();
  }
  std::array<Column<double>, 2> places;
  if (settings.track_energy) places = {bodies.x[0], bodies.x[1]};
  team->run([&](std::size_t t) {
    const std::size_t end = t + 1 == team->size() ? padded : bounds[t + 1];
    moved[t] = move_bodies(motion, bounds[t], end);
  });
  ++step;
  double slack = wall_slack;
  for (const auto& result : moved) {
    if (result.outside) blame_outside();
    slack = std::min(slack, static_cast<double>(result.smallest_slack));
  }
  if (settings.track_energy) book_crossings(places);
  cost.seconds_motion += watch.lap();
  if (stale || coefficients_stale || !(slack >= 0.0)) {
    refresh();
    watch.lap();
  }
  if (awake_end < bodies.count) reset_sleepers();
  evaluate();
  cost.seconds_contacts += watch.lap();
  ++cost.steps;
  if (settings.track_energy) record_losses();
  if (settings.sleep.enabled) check_sleep();
}

ContactTask System::Impl::contact_task(PairList& pairs, Column<float>& trace) {
  ContactTask task;
  task.pairs = &pairs;
  task.spheres = &spheres;
  task.bodies = &bodies;
  task.laws = &laws;
  task.period = &period;
  task.quanta = quanta;
  task.law = law;
  task.time_step = time_step;
  if (settings.track_energy) {
    trace.resize(Trace::kColumns * pairs.size);
    task.trace = trace.data();
    task.trace_stride = pairs.size;
  }
  return task;
}

ContactResult System::Impl::evaluate_walls_of(std::size_t slot) {
  walls.collect(slot, spheres, period, law.rolling);
  WallTask task{&walls.contacts(slot), &spheres, &bodies, &laws, quanta, law, time_step, nullptr, 0};
  if (settings.track_energy) {
    task.trace_stride = task.contacts->sphere.size();
    walls.trace(slot).resize(Trace::kColumns * task.trace_stride);
    task.trace = walls.trace(slot).data();
  }
  const ContactResult result = evaluate_walls(task);
  walls.finish(slot, quanta, law.rolling);
  return result;
}

void System::Impl::evaluate() {
  const std::size_t parts = lists.size();
  traces.resize(parts);
  std::vector<ContactResult> results(2 * parts);
  const auto pairs_of = [&](std::size_t part) {
    return evaluate_pairs(contact_task(lists[part], traces[part]), 0, lists[part].size);
  };
  team->run([&](std::size_t t) {
    results[t] = pairs_of(t);
    if (walls.parts().empty()) return;
    Stopwatch watch;
    results[parts + t] = evaluate_walls_of(t);
    if (t == 0) cost.seconds_walls += watch.lap();
  });
  results[parts - 1] = pairs_of(parts - 1);
  walls.sum_wrenches();
  touching = 0;
  cost.candidates = 0;
  for (const auto& list : lists) cost.candidates += list.size;
  for (std::size_t p = 0; p < results.size(); ++p) {
    if (p < parts) touching += results[p].touching;
    if (results[p].worst > 0.0F) blame_overlap();
  }
}

void System::Impl::blame_outside() const {
  for (std::size_t r = 0; r < bodies.count; ++r) {
    const std::size_t b = index_of_rank[r];
    bool inside = true;
    for (int a = 0; a < 3; ++a)
      inside = inside && bodies.x[a][b] >= period.low[a] && bodies.x[a][b] <= period.high[a];
    if (inside) continue;
    throw Error(fmt::format(
        "step {}: particle {} at ({:.4g}, {:.4g}, {:.4g}) m, speed ({:.3g}, {:.3g}, {:.3g}) m/s: {}", step, r,
        bodies.x[0][b], bodies.x[1][b], bodies.x[2][b], bodies.v[0][b], bodies.v[1][b], bodies.v[2][b],
        std::isfinite(bodies.x[0][b] + bodies.x[1][b] + bodies.x[2][b]) ? "outside the domain"
                                                                        : "not finite"));
  }
  throw Error(fmt::format("step {}: a particle left the domain", step));
}

void System::Impl::blame_overlap() const {
  const auto particle_at = [&](std::uint32_t sphere) { return bodies.rank[spheres.body[sphere]]; };
  for (const auto& list : lists) {
    for (std::size_t n = 0; n < list.size; ++n) {
      if (list.i[n] >= spheres.count) continue;
      const float radius = std::min(spheres.row[list.i[n]].radius, spheres.row[list.j[n]].radius);
      const float overlap = list.columns[PairList::kOverlap][n];
      if (overlap > kDeepestOverlap * radius) {
        throw Error(fmt::format("step {}: particles {} and {} overlap by {:.3g} m, {:.0f} % of a radius",
                                step, particle_at(list.i[n]), particle_at(list.j[n]), overlap,
                                100.0 * overlap / radius));
      }
    }
  }
  for (std::size_t t = 0; t < walls.threads(); ++t) {
    for (const auto& touch : walls.touches(t)) {
      const float radius = spheres.row[touch.sphere].radius;
      if (touch.overlap > kDeepestOverlap * radius) {
        throw Error(fmt::format("step {}: particle {} is {:.3g} m deep in wall '{}', {:.0f} % of a radius",
                                step, particle_at(touch.sphere), touch.overlap,
                                walls.parts()[touch.part].wall.name, 100.0 * touch.overlap / radius));
      }
    }
  }
  throw Error(fmt::format("step {}: particles overlap too deeply", step));
}

}  // namespace wheel_twin::dem
