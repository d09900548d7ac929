#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "dem/contact_kernel.cpp"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "dem/contact_law-inl.h"
#include "dem/kernels.h"
#include "dem/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace wheel_twin::dem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Constants of the law for a batch: one set for all, or looked up by pair of materials.
template <bool kManyLaws>
struct LawLanes {
  explicit LawLanes(const LawTable& table) : table_(table) {}
  HWY_INLINE void Fill(const std::uint8_t* law, Contact<VF>& c) const {
    const DF df;
    if constexpr (kManyLaws) {
      const auto index = hn::PromoteTo(DFI(), hn::LoadU(hn::Rebind<std::uint8_t, DF>(), law));
      c.shear_ratio = hn::GatherIndex(df, table_.shear_ratio.data(), index);
      c.shear_ratio_root = hn::GatherIndex(df, table_.shear_ratio_root.data(), index);
      c.friction = hn::GatherIndex(df, table_.friction.data(), index);
      c.rolling = hn::GatherIndex(df, table_.rolling.data(), index);
      c.cohesion = hn::GatherIndex(df, table_.cohesion.data(), index);
    } else {
      c.shear_ratio = hn::Set(df, table_.shear_ratio[0]);
      c.shear_ratio_root = hn::Set(df, table_.shear_ratio_root[0]);
      c.friction = hn::Set(df, table_.friction[0]);
      c.rolling = hn::Set(df, table_.rolling[0]);
      c.cohesion = hn::Set(df, table_.cohesion[0]);
    }
  }
  const LawTable& table_;
};

template <bool kRolling>
HWY_INLINE ContactHistoryVector<VF> LoadHistory(const float* const* columns, std::size_t at) {
  const DF df;
  ContactHistoryVector<VF> h;
  h.shear = {hn::LoadU(df, columns[0] + at), hn::LoadU(df, columns[1] + at), hn::LoadU(df, columns[2] + at)};
  h.overlap = hn::LoadU(df, columns[3] + at);
  if constexpr (kRolling) {
    h.rolling = {hn::LoadU(df, columns[4] + at), hn::LoadU(df, columns[5] + at),
                 hn::LoadU(df, columns[6] + at)};
  } else {
    h.rolling = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
  }
  return h;
}

template <bool kRolling>
HWY_INLINE void StoreHistory(const ContactHistoryVector<VF>& h, float* const* columns, std::size_t at) {
  const DF df;
  hn::StoreU(h.shear.x, df, columns[0] + at);
  hn::StoreU(h.shear.y, df, columns[1] + at);
  hn::StoreU(h.shear.z, df, columns[2] + at);
  hn::StoreU(h.overlap, df, columns[3] + at);
  if constexpr (kRolling) {
    hn::StoreU(h.rolling.x, df, columns[4] + at);
    hn::StoreU(h.rolling.y, df, columns[5] + at);
    hn::StoreU(h.rolling.z, df, columns[6] + at);
  }
}

HWY_INLINE void StoreTrace(float* trace, std::size_t stride, std::size_t at, const Contact<VF>& c,
                           const ContactResponse<VF>& r) {
  const DF df;
  const VF columns[Trace::kColumns] = {
      c.velocity.x, c.velocity.y,     c.velocity.z, r.force.x, r.force.y, r.force.z,  c.normal.x, c.normal.y,
      c.normal.z,   r.damping_normal, c.spin.x,     c.spin.y,  c.spin.z,  r.torque.x, r.torque.y, r.torque.z};
  for (int k = 0; k < Trace::kColumns; ++k) hn::StoreU(columns[k], df, trace + k * stride + at);
}

constexpr std::size_t kAhead = 80;  ///< pairs: what lies so far ahead is asked from memory

template <bool kRolling, bool kCohesion, bool kManyLaws>
ContactResult EvaluatePairsOf(const ContactTask& task, std::size_t begin, std::size_t end) {
  const D d;
  const DF df;
  const std::size_t lanes = hn::Lanes(d);
  PairList& pairs = *task.pairs;
  const SphereRow* rows = task.spheres->row.data();
  const std::uint32_t* body = task.spheres->body.data();
  LoadRow* loads = task.bodies->load.data();
  const float* stiffness = pairs.columns[PairList::kStiffness].data();
  const float* damping = pairs.columns[PairList::kDamping].data();
  float* history_columns[7];
  for (int k = 0; k < 7; ++k) history_columns[k] = pairs.columns[PairList::kShear + k].data();
  const LawLanes<kManyLaws> law(*task.laws);
  const Period& period = *task.period;
  const VD half = hn::Set(d, 0.5);
  const VF half_f = hn::Set(df, 0.5F);
  const VF dt = hn::Set(df, static_cast<float>(task.time_step));
  const VF one_over_dt = hn::Set(df, static_cast<float>(1.0 / task.time_step));
  const VD force_magic = hn::Set(d, task.quanta.force_magic);
  const VD torque_magic = hn::Set(d, task.quanta.torque_magic);
  const VD length_x = hn::Set(d, period.length[0]), inverse_x = hn::Set(d, period.inverse[0]);
  const VD length_y = hn::Set(d, period.length[1]), inverse_y = hn::Set(d, period.inverse[1]);
  VF worst = hn::Set(df, -1.0F);
  ContactResult result;

  for (std::size_t at = begin; at < end; at += lanes) {
    const std::uint32_t* i = pairs.i.data() + at;
    const std::uint32_t* j = pairs.j.data() + at;
    if (at + kAhead + lanes <= end) {
      for (std::size_t k = kAhead; k < kAhead + lanes; ++k) {
        hwy::Prefetch(rows + i[k]);
        hwy::Prefetch(rows + j[k]);
        hwy::Prefetch(loads + body[i[k - kAhead / 2]]);
        hwy::Prefetch(loads + body[j[k - kAhead / 2]]);
      }
    }
    const SphereLanes a = LoadSpheres(rows, i);
    const SphereLanes b = LoadSpheres(rows, j);
    Vector3<VD> between = Minus(a.x, b.x);
    between.x = hn::NegMulAdd(length_x, hn::Round(hn::Mul(between.x, inverse_x)), between.x);
    between.y = hn::NegMulAdd(length_y, hn::Round(hn::Mul(between.y, inverse_y)), between.y);
    const VD distance = hn::Sqrt(Dot(between, between));
    const VD radius_a = hn::PromoteTo(d, a.radius), radius_b = hn::PromoteTo(d, b.radius);
    const VD overlap = hn::Sub(hn::Add(radius_a, radius_b), distance);
    ContactHistoryVector<VF> history = LoadHistory<kRolling>(history_columns, at);
    Contact<VF> c;
    c.overlap = hn::DemoteTo(df, overlap);
    const auto touching = hn::Gt(c.overlap, hn::Zero(df));
    const std::size_t count = hn::CountTrue(df, touching);
    if (count == 0) {
      const VF zero = hn::Zero(df);
      StoreHistory<kRolling>({{zero, zero, zero}, zero, {zero, zero, zero}}, history_columns, at);
      if (task.trace == nullptr) continue;
    }
    result.touching += count;
    worst =
        hn::Max(worst, hn::NegMulAdd(hn::Set(df, kDeepestOverlap), hn::Min(a.radius, b.radius), c.overlap));

    const VD inverse_distance = hn::Div(hn::Set(d, 1.0), hn::Max(distance, hn::Set(d, 1e-300)));
    const Vector3<VD> normal = Scaled(between, inverse_distance);
    // The contact point lies in the middle of the overlap.
    const VD arm_a = hn::Mul(half, hn::Add(distance, hn::Sub(radius_a, radius_b)));
    const VD arm_b = hn::Mul(half, hn::Add(distance, hn::Sub(radius_b, radius_a)));
    const Vector3<VD> lever_a = MinusScaled(Wide(a.lever), arm_a, normal);
    const Vector3<VD> lever_b = PlusScaled(Wide(b.lever), arm_b, normal);
    c.normal = Narrow(normal);
    const Vector3<VF> turn_a = Cross(a.w, Narrow(lever_a)), turn_b = Cross(b.w, Narrow(lever_b));
    c.velocity =
        Minus(Vector3<VF>{hn::Add(a.v.x, turn_a.x), hn::Add(a.v.y, turn_a.y), hn::Add(a.v.z, turn_a.z)},
              Vector3<VF>{hn::Add(b.v.x, turn_b.x), hn::Add(b.v.y, turn_b.y), hn::Add(b.v.z, turn_b.z)});
    c.spin = Minus(a.w, b.w);
    c.mean_spin = hn::Mul(
        half_f,
        Dot(Vector3<VF>{hn::Add(a.w.x, b.w.x), hn::Add(a.w.y, b.w.y), hn::Add(a.w.z, b.w.z)}, c.normal));
    c.radius = hn::Zero(df);
    if constexpr (kRolling || kCohesion) {
      c.radius = hn::Div(hn::Mul(a.radius, b.radius), hn::Add(a.radius, b.radius));
    }
    c.stiffness = hn::LoadU(df, stiffness + at);
    c.damping = hn::LoadU(df, damping + at);
    law.Fill(kManyLaws ? pairs.law.data() + at : nullptr, c);
    const ContactResponse<VF> response = EvaluateContact<kRolling, kCohesion>(c, dt, one_over_dt, history);
    StoreHistory<kRolling>(history, history_columns, at);
    if (task.trace != nullptr) StoreTrace(task.trace, task.trace_stride, at, c, response);

    const Vector3<VD> force = RoundedTo(Wide(response.force), force_magic);
    // The same form on both sides: which of the two is a depends on the lists, and a fused product is not
    // antisymmetric.
    const Vector3<VD> opposite{hn::Neg(force.x), hn::Neg(force.y), hn::Neg(force.z)};
    Vector3<VD> torque_a = Cross(lever_a, force);
    Vector3<VD> torque_b = Cross(lever_b, opposite);
    if constexpr (kRolling) {
      const Vector3<VD> rolling = Wide(response.torque);
      torque_a = PlusScaled(torque_a, hn::Set(d, 1.0), rolling);
      torque_b = MinusScaled(torque_b, hn::Set(d, 1.0), rolling);
    }
    const VD pressure = RoundedTo(hn::PromoteTo(d, response.pressure), force_magic);
    HWY_ALIGN std::uint32_t body_a[kBatch], body_b[kBatch];
    for (std::size_t k = 0; k < lanes; ++k) {
      body_a[k] = body[i[k]];
      body_b[k] = body[j[k]];
    }
    AddLoads(force, RoundedTo(torque_a, torque_magic), pressure, loads, body_a);
    AddLoads(opposite, RoundedTo(torque_b, torque_magic), pressure, loads, body_b);
  }
  result.worst = hn::GetLane(hn::MaxOfLanes(df, worst));
  return result;
}

template <bool kRolling, bool kCohesion>
ContactResult EvaluatePairsWith(const ContactTask& task, std::size_t begin, std::size_t end) {
  return task.pairs->law.empty() ? EvaluatePairsOf<kRolling, kCohesion, false>(task, begin, end)
                                 : EvaluatePairsOf<kRolling, kCohesion, true>(task, begin, end);
}

ContactResult EvaluatePairs(const ContactTask& task, std::size_t begin, std::size_t end) {
  if (task.law.rolling) return EvaluatePairsWith<true, true>(task, begin, end);
  if (task.law.cohesive) return EvaluatePairsWith<false, true>(task, begin, end);
  return EvaluatePairsWith<false, false>(task, begin, end);
}

template <bool kRolling, bool kCohesion>
ContactResult EvaluateWallsOf(const WallTask& task) {
  const D d;
  const DF df;
  const std::size_t lanes = hn::Lanes(d);
  WallContacts& contacts = *task.contacts;
  const SphereRow* rows = task.spheres->row.data();
  const std::uint32_t* body = task.spheres->body.data();
  LoadRow* loads = task.bodies->load.data();
  float* history_columns[7] = {contacts.shear[0].data(),   contacts.shear[1].data(),
                               contacts.shear[2].data(),   contacts.overlap.data(),
                               contacts.rolling[0].data(), contacts.rolling[1].data(),
                               contacts.rolling[2].data()};
  const LawLanes<true> law(*task.laws);
  const VF dt = hn::Set(df, static_cast<float>(task.time_step));
  const VF one_over_dt = hn::Set(df, static_cast<float>(1.0 / task.time_step));
  const VD force_magic = hn::Set(d, task.quanta.force_magic);
  const VD torque_magic = hn::Set(d, task.quanta.torque_magic);
  const auto vector = [&](const Column<double>* columns, std::size_t at) {
    return Vector3<VD>{hn::LoadU(d, columns[0].data() + at), hn::LoadU(d, columns[1].data() + at),
                       hn::LoadU(d, columns[2].data() + at)};
  };
  const auto vector_f = [&](const Column<float>* columns, std::size_t at) {
    return Vector3<VF>{hn::LoadU(df, columns[0].data() + at), hn::LoadU(df, columns[1].data() + at),
                       hn::LoadU(df, columns[2].data() + at)};
  };
  VF worst = hn::Set(df, -1.0F);
  ContactResult result;
  for (std::size_t at = 0; at < contacts.size; at += lanes) {
    const std::uint32_t* i = contacts.sphere.data() + at;
    for (std::size_t k = kAhead / 2; k < kAhead / 2 + lanes && at + k < contacts.size; ++k)
      hwy::Prefetch(loads + body[i[k]]);
    const SphereLanes a = LoadSpheres(rows, i);
    const VD distance = hn::LoadU(d, contacts.distance.data() + at);
    const Vector3<VD> normal = vector(contacts.normal, at);
    const VD radius = hn::PromoteTo(d, a.radius);
    Contact<VF> c;
    c.overlap = hn::DemoteTo(df, hn::Sub(radius, distance));
    result.touching += hn::CountTrue(df, hn::Gt(c.overlap, hn::Zero(df)));
    worst = hn::Max(worst, hn::NegMulAdd(hn::Set(df, kDeepestOverlap), a.radius, c.overlap));
    const Vector3<VD> lever = MinusScaled(Wide(a.lever), distance, normal);
    const Vector3<VF> turn = Cross(a.w, Narrow(lever));
    c.normal = Narrow(normal);
    c.velocity = Minus(Vector3<VF>{hn::Add(a.v.x, turn.x), hn::Add(a.v.y, turn.y), hn::Add(a.v.z, turn.z)},
                       vector_f(contacts.velocity, at));
    const Vector3<VF> wall_spin = vector_f(contacts.spin, at);
    c.spin = Minus(a.w, wall_spin);
    // A wall is flat: only its own spin turns the spring about the normal.
    c.mean_spin = Dot(wall_spin, c.normal);
    c.radius = a.radius;
    c.stiffness = hn::LoadU(df, contacts.stiffness.data() + at);
    c.damping = hn::LoadU(df, contacts.damping.data() + at);
    law.Fill(contacts.law.data() + at, c);
    ContactHistoryVector<VF> history = LoadHistory<kRolling>(history_columns, at);
    const ContactResponse<VF> response = EvaluateContact<kRolling, kCohesion>(c, dt, one_over_dt, history);
    StoreHistory<kRolling>(history, history_columns, at);
    if (task.trace != nullptr) StoreTrace(task.trace, task.trace_stride, at, c, response);
    const Vector3<VD> force = RoundedTo(Wide(response.force), force_magic);
    Vector3<VD> torque = Cross(lever, force);
    if constexpr (kRolling) {
      torque = PlusScaled(torque, hn::Set(d, 1.0), Wide(response.torque));
      hn::StoreU(response.torque.x, df, contacts.moment[0].data() + at);
      hn::StoreU(response.torque.y, df, contacts.moment[1].data() + at);
      hn::StoreU(response.torque.z, df, contacts.moment[2].data() + at);
    }
    hn::StoreU(force.x, d, contacts.force[0].data() + at);
    hn::StoreU(force.y, d, contacts.force[1].data() + at);
    hn::StoreU(force.z, d, contacts.force[2].data() + at);
    HWY_ALIGN std::uint32_t bodies[kBatch];
    for (std::size_t k = 0; k < lanes; ++k) bodies[k] = body[i[k]];
    AddLoads(force, RoundedTo(torque, torque_magic),
             RoundedTo(hn::PromoteTo(d, response.pressure), force_magic), loads, bodies);
  }
  result.worst = hn::GetLane(hn::MaxOfLanes(df, worst));
  return result;
}

ContactResult EvaluateWalls(const WallTask& task) {
  if (task.law.rolling) return EvaluateWallsOf<true, true>(task);
  return task.law.cohesive ? EvaluateWallsOf<false, true>(task) : EvaluateWallsOf<false, false>(task);
}

const char* InstructionSet() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace wheel_twin::dem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace wheel_twin::dem {

HWY_EXPORT(EvaluatePairs);
HWY_EXPORT(EvaluateWalls);
HWY_EXPORT(InstructionSet);

ContactResult evaluate_pairs(const ContactTask& task, std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(EvaluatePairs)(task, begin, end);
}
ContactResult evaluate_walls(const WallTask& task) {
  return HWY_DYNAMIC_DISPATCH(EvaluateWalls)(task);
}
const char* instruction_set() {
  return HWY_DYNAMIC_DISPATCH(InstructionSet)();
}

void WallContacts::resize(std::size_t entries, bool rolls) {
  size = entries;
  const std::size_t padded = (entries + kBatch - 1) / kBatch * kBatch;
  sphere.resize(padded);
  law.resize(padded);
  for (auto* column : {&distance}) column->resize(padded);
  for (auto* column : {&stiffness, &damping, &overlap}) column->resize(padded);
  for (int k = 0; k < 3; ++k) {
    normal[k].resize(padded);
    velocity[k].resize(padded);
    spin[k].resize(padded);
    shear[k].resize(padded);
    force[k].resize(padded);
    if (!rolls) continue;
    rolling[k].resize(padded);
    moment[k].resize(padded);
  }
}

}  // namespace wheel_twin::dem
#endif
