// Free rotation of rigid bodies by a symplectic splitting about the body's principal axes (Dullweber,
// Leimkuhler and McLachlan 1997): x half, y half, z whole, y half, x half. Each part turns the body about one
// axis by the angle h L_k / I_k and leaves |L| alone; the turn is taken as 4 atan(angle / 4), which agrees to
// third order, is the exact flow of a nearby Hamiltonian and needs no trigonometry. So the energy of a free
// asymmetric body has no drift, and the angular momentum in world axes, which is what the engine stores, does
// not change at all.
#if defined(WHEEL_TWIN_ROTATION_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef WHEEL_TWIN_ROTATION_INL_H
#undef WHEEL_TWIN_ROTATION_INL_H
#else
#define WHEEL_TWIN_ROTATION_INL_H
#endif

#include "dem/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace wheel_twin::dem::HWY_NAMESPACE {

struct QuaternionLanes {
  VD w, x, y, z;
};

/// Rows of the rotation matrix, body to world.
struct RotationLanes {
  Vector3<VD> row_x, row_y, row_z;
};

HWY_INLINE RotationLanes MatrixOf(const QuaternionLanes& q) {
  const D d;
  const VD two = hn::Set(d, 2.0), one = hn::Set(d, 1.0);
  const VD x2 = hn::Mul(two, q.x), y2 = hn::Mul(two, q.y), z2 = hn::Mul(two, q.z);
  const VD xx = hn::Mul(q.x, x2), yy = hn::Mul(q.y, y2), zz = hn::Mul(q.z, z2);
  const VD wx = hn::Mul(q.w, x2), wy = hn::Mul(q.w, y2), wz = hn::Mul(q.w, z2);
  return {{hn::Sub(one, hn::Add(yy, zz)), hn::MulSub(q.x, y2, wz), hn::MulAdd(q.x, z2, wy)},
          {hn::MulAdd(q.x, y2, wz), hn::Sub(one, hn::Add(xx, zz)), hn::MulSub(q.y, z2, wx)},
          {hn::MulSub(q.x, z2, wy), hn::MulAdd(q.y, z2, wx), hn::Sub(one, hn::Add(xx, yy))}};
}

HWY_INLINE Vector3<VD> ToWorld(const RotationLanes& r, const Vector3<VD>& a) {
  return {Dot(r.row_x, a), Dot(r.row_y, a), Dot(r.row_z, a)};
}
HWY_INLINE Vector3<VD> ToBody(const RotationLanes& r, const Vector3<VD>& a) {
  return PlusScaled(PlusScaled(Scaled(r.row_x, a.x), a.y, r.row_y), a.z, r.row_z);
}

/// Half angle of the turn about one axis.
struct HalfTurn {
  VD c, s;
};
HWY_INLINE HalfTurn TurnBy(const VD quarter_angle) {
  const D d;
  const VD one = hn::Set(d, 1.0);
  const VD square = hn::Mul(quarter_angle, quarter_angle);
  const VD inverse = hn::Div(one, hn::Add(one, square));
  return {hn::Mul(hn::Sub(one, square), inverse), hn::Mul(hn::Add(quarter_angle, quarter_angle), inverse)};
}

/// Turns the components (u, v) of the momentum, which follow the turned axis in cyclic order.
HWY_INLINE void TurnMomentum(const HalfTurn& t, VD& u, VD& v) {
  const VD cosine = hn::MulSub(t.c, t.c, hn::Mul(t.s, t.s));
  const VD sine = hn::Mul(hn::Add(t.c, t.c), t.s);
  const VD new_u = hn::MulAdd(cosine, u, hn::Mul(sine, v));
  v = hn::MulSub(cosine, v, hn::Mul(sine, u));
  u = new_u;
}

HWY_INLINE void TurnAboutX(const VD factor, const Vector3<VD>& inverse_inertia, QuaternionLanes& q,
                           Vector3<VD>& l) {
  const HalfTurn t = TurnBy(hn::Mul(factor, hn::Mul(l.x, inverse_inertia.x)));
  TurnMomentum(t, l.y, l.z);
  q = {hn::MulSub(q.w, t.c, hn::Mul(q.x, t.s)), hn::MulAdd(q.x, t.c, hn::Mul(q.w, t.s)),
       hn::MulAdd(q.y, t.c, hn::Mul(q.z, t.s)), hn::MulSub(q.z, t.c, hn::Mul(q.y, t.s))};
}
HWY_INLINE void TurnAboutY(const VD factor, const Vector3<VD>& inverse_inertia, QuaternionLanes& q,
                           Vector3<VD>& l) {
  const HalfTurn t = TurnBy(hn::Mul(factor, hn::Mul(l.y, inverse_inertia.y)));
  TurnMomentum(t, l.z, l.x);
  q = {hn::MulSub(q.w, t.c, hn::Mul(q.y, t.s)), hn::MulSub(q.x, t.c, hn::Mul(q.z, t.s)),
       hn::MulAdd(q.y, t.c, hn::Mul(q.w, t.s)), hn::MulAdd(q.z, t.c, hn::Mul(q.x, t.s))};
}
HWY_INLINE void TurnAboutZ(const VD factor, const Vector3<VD>& inverse_inertia, QuaternionLanes& q,
                           Vector3<VD>& l) {
  const HalfTurn t = TurnBy(hn::Mul(factor, hn::Mul(l.z, inverse_inertia.z)));
  TurnMomentum(t, l.x, l.y);
  q = {hn::MulSub(q.w, t.c, hn::Mul(q.z, t.s)), hn::MulAdd(q.x, t.c, hn::Mul(q.y, t.s)),
       hn::MulSub(q.y, t.c, hn::Mul(q.x, t.s)), hn::MulAdd(q.z, t.c, hn::Mul(q.w, t.s))};
}

/// Turns `q` by the free motion over `time_step`; `body_momentum` in body axes, turned along.
HWY_INLINE void RotateFreely(const VD time_step, const Vector3<VD>& inverse_inertia, QuaternionLanes& q,
                             Vector3<VD>& body_momentum) {
  const D d;
  const VD whole = hn::Mul(hn::Set(d, 0.25), time_step);  // a quarter of the angle, see TurnBy
  const VD half = hn::Mul(hn::Set(d, 0.125), time_step);
  TurnAboutX(half, inverse_inertia, q, body_momentum);
  TurnAboutY(half, inverse_inertia, q, body_momentum);
  TurnAboutZ(whole, inverse_inertia, q, body_momentum);
  TurnAboutY(half, inverse_inertia, q, body_momentum);
  TurnAboutX(half, inverse_inertia, q, body_momentum);
  const VD square = hn::MulAdd(q.w, q.w, hn::MulAdd(q.x, q.x, hn::MulAdd(q.y, q.y, hn::Mul(q.z, q.z))));
  const VD scale = hn::NegMulAdd(hn::Set(d, 0.5), square, hn::Set(d, 1.5));
  q = {hn::Mul(q.w, scale), hn::Mul(q.x, scale), hn::Mul(q.y, scale), hn::Mul(q.z, scale)};
}

}  // namespace wheel_twin::dem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
