#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "dem/motion_kernel.cpp"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "dem/kernels.h"
#include "dem/lanes-inl.h"
#include "dem/rotation-inl.h"

HWY_BEFORE_NAMESPACE();
namespace wheel_twin::dem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE Vector3<VD> Load3(const Column<double>* columns, std::size_t at) {
  const D d;
  return {hn::LoadU(d, columns[0].data() + at), hn::LoadU(d, columns[1].data() + at),
          hn::LoadU(d, columns[2].data() + at)};
}
HWY_INLINE void Store3(const Vector3<VD>& a, Column<double>* columns, std::size_t at) {
  const D d;
  hn::StoreU(a.x, d, columns[0].data() + at);
  hn::StoreU(a.y, d, columns[1].data() + at);
  hn::StoreU(a.z, d, columns[2].data() + at);
}

/// Spheres of a batch of bodies.
struct SpherePlacer {
  SpherePlacer(const MotionTask& t) : task(t), nowhere(static_cast<std::uint32_t>(t.spheres->count + 2)) {}

  HWY_INLINE void Place(std::size_t at, SphereLanes& s, const Vector3<VD>& center,
                        const RotationLanes* rotation) const {
    const D d;
    const DF df;
    const ShapeTable& shapes = *task.shapes;
    const std::size_t lanes = hn::Lanes(d);
    const VD size = hn::PromoteTo(d, hn::LoadU(df, task.bodies->size.data() + at));
    HWY_ALIGN std::int64_t entry[kBatch];
    std::uint32_t count[kBatch];
    std::uint32_t most = 0;
    for (std::size_t k = 0; k < lanes; ++k) {
      const std::uint32_t shape = task.bodies->shape[at + k];
      entry[k] = 16 * static_cast<std::int64_t>(shape);
      count[k] = at + k < task.bodies->count ? shapes.count[shape] : 0;
      most = count[k] > most ? count[k] : most;
    }
    auto index = hn::Load(DI(), entry);
    const bool few = lanes == kBatch && !shapes.few[0].empty();
    const auto which =
        hn::IndicesFromVec(d, few ? hn::BitCast(hn::RebindToUnsigned<DI>(), hn::ShiftRight<4>(index))
                                  : hn::Zero(hn::RebindToUnsigned<DI>()));
    const auto look_up = [&](int column, const Column<double>& values, std::uint32_t k) {
      return few ? hn::TableLookupLanes(hn::Load(d, shapes.few[column].data() + kBatch * k), which)
                 : hn::GatherIndex(d, values.data(), index);
    };
    for (std::uint32_t k = 0; k < most; ++k) {
      s.radius = hn::DemoteTo(df, hn::Mul(size, look_up(3, shapes.radius, k)));
      if (rotation != nullptr) {
        const Vector3<VD> local{hn::Mul(size, look_up(0, shapes.x, k)),
                                hn::Mul(size, look_up(1, shapes.y, k)),
                                hn::Mul(size, look_up(2, shapes.z, k))};
        s.lever = Narrow(ToWorld(*rotation, local));
        const Vector3<VD> lever = Wide(s.lever);
        s.x = {hn::Add(center.x, lever.x), hn::Add(center.y, lever.y), hn::Add(center.z, lever.z)};
      } else {
        s.lever = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
        s.x = center;
      }
      HWY_ALIGN std::uint32_t place[kBatch];
      for (std::size_t m = 0; m < lanes; ++m)
        place[m] = k < count[m] ? task.bodies->first[at + m] + k : nowhere;
      StoreSpheres(s, task.spheres->row.data(), place, nowhere);
      index = hn::Add(index, hn::Set(DI(), 1));
    }
  }

  const MotionTask& task;
  std::uint32_t nowhere;
};

template <bool kMove>
MotionResult UpdateBodies(const MotionTask& task, std::size_t begin, std::size_t end) {
  const D d;
  const DF df;
  const std::size_t lanes = hn::Lanes(d);
  Bodies& b = *task.bodies;
  const bool oriented = !b.q[0].empty();
  const SpherePlacer placer(task);
  const VD whole_step = hn::Set(d, task.time_step);
  const VF dt_f = hn::Set(df, static_cast<float>(task.time_step));
  const Vector3<VD> gravity{hn::Set(d, task.gravity[0]), hn::Set(d, task.gravity[1]),
                            hn::Set(d, task.gravity[2])};
  const auto wrap = [&](VD x, int axis, auto& inside) {
    const VD low = hn::Set(d, task.period->low[axis]), high = hn::Set(d, task.period->high[axis]);
    if (task.period->inverse[axis] != 0.0) {
      const VD length = hn::Set(d, task.period->length[axis]);
      x = hn::IfThenElse(hn::Lt(x, low), hn::Add(x, length), x);
      x = hn::IfThenElse(hn::Ge(x, high), hn::Sub(x, length), x);
    }
    inside = hn::And(inside, hn::And(hn::Ge(x, low), hn::Le(x, high)));
    return x;
  };
  auto inside = hn::Eq(whole_step, whole_step);
  VF smallest = hn::Set(df, 1e30F);

  for (std::size_t at = begin; at < end; at += lanes) {
    // A sleeping body has no velocity: with a step of zero it stays as it is to the bit.
    const VD dt =
        at + lanes <= task.awake_end
            ? whole_step
            : hn::IfThenElseZero(hn::FirstN(d, task.awake_end > at ? task.awake_end - at : std::size_t{0}),
                                 whole_step);
    Vector3<VD> x = Load3(b.x, at);
    Vector3<VD> v = Load3(b.v, at);
    Vector3<VD> l = Load3(b.l, at);
    Vector3<VD> w;
    RotationLanes rotation{};
    if constexpr (kMove) {
      Vector3<VD> force, torque;
      TakeLoads(b.load.data() + at, force, torque);
      const VD inverse_mass = hn::LoadU(d, b.inverse_mass.data() + at);
      const auto real = hn::Gt(inverse_mass, hn::Zero(d));
      const Vector3<VD> weight{hn::IfThenElseZero(real, gravity.x), hn::IfThenElseZero(real, gravity.y),
                               hn::IfThenElseZero(real, gravity.z)};
      v = PlusScaled(v, dt, PlusScaled(weight, inverse_mass, force));
      l = PlusScaled(l, dt, torque);
      x = PlusScaled(x, dt, v);
      x = {wrap(x.x, 0, inside), wrap(x.y, 1, inside), wrap(x.z, 2, inside)};
      Store3(x, b.x, at);
      Store3(v, b.v, at);
      Store3(l, b.l, at);
    }
    if (oriented) {
      const Vector3<VD> inverse_inertia = Load3(b.inverse_inertia, at);
      QuaternionLanes q{hn::LoadU(d, b.q[0].data() + at), hn::LoadU(d, b.q[1].data() + at),
                        hn::LoadU(d, b.q[2].data() + at), hn::LoadU(d, b.q[3].data() + at)};
      rotation = MatrixOf(q);
      Vector3<VD> momentum = ToBody(rotation, l);
      if constexpr (kMove) {
        RotateFreely(dt, inverse_inertia, q, momentum);
        rotation = MatrixOf(q);
        hn::StoreU(q.w, d, b.q[0].data() + at);
        hn::StoreU(q.x, d, b.q[1].data() + at);
        hn::StoreU(q.y, d, b.q[2].data() + at);
        hn::StoreU(q.z, d, b.q[3].data() + at);
      }
      w = ToWorld(rotation, {hn::Mul(momentum.x, inverse_inertia.x), hn::Mul(momentum.y, inverse_inertia.y),
                             hn::Mul(momentum.z, inverse_inertia.z)});
    } else {
      w = Scaled(l, hn::LoadU(d, b.inverse_inertia[0].data() + at));
    }
    SphereLanes s;
    s.v = Narrow(v);
    s.w = Narrow(w);
    if constexpr (kMove) {
      const VF speed =
          hn::MulAdd(hn::LoadU(df, b.reach.data() + at), hn::Sqrt(Dot(s.w, s.w)), hn::Sqrt(Dot(s.v, s.v)));
      // A thousandth covers the rounding of many small ways.
      const VF slack =
          hn::NegMulAdd(hn::Mul(dt_f, hn::Set(df, 1.001F)), speed, hn::LoadU(df, b.slack.data() + at));
      hn::StoreU(slack, df, b.slack.data() + at);
      smallest = hn::IfThenElse(hn::Ge(slack, smallest), smallest, slack);
    }
    placer.Place(at, s, x, oriented ? &rotation : nullptr);
  }
  MotionResult result;
  result.smallest_slack = hn::GetLane(hn::MinOfLanes(df, smallest));
  result.outside = !hn::AllTrue(d, inside);
  return result;
}

MotionResult MoveBodies(const MotionTask& task, std::size_t begin, std::size_t end) {
  return UpdateBodies<true>(task, begin, end);
}
void PlaceSpheres(const MotionTask& task, std::size_t begin, std::size_t end) {
  UpdateBodies<false>(task, begin, end);
}

}  // namespace wheel_twin::dem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace wheel_twin::dem {

HWY_EXPORT(MoveBodies);
HWY_EXPORT(PlaceSpheres);

MotionResult move_bodies(const MotionTask& task, std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(MoveBodies)(task, begin, end);
}
void place_spheres(const MotionTask& task, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(PlaceSpheres)(task, begin, end);
}

}  // namespace wheel_twin::dem
#endif
