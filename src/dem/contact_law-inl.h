// The contact laws of contact_law.h on a vector of contacts. Included once for every instruction set
// (Highway), so the guard toggles with the target. All quantities in single precision, SI units.
#if defined(WHEEL_TWIN_CONTACT_LAW_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef WHEEL_TWIN_CONTACT_LAW_INL_H
#undef WHEEL_TWIN_CONTACT_LAW_INL_H
#else
#define WHEEL_TWIN_CONTACT_LAW_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace wheel_twin::dem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class V>
struct Vector3 {
  V x, y, z;
};

template <class V>
HWY_INLINE V Dot(const Vector3<V>& a, const Vector3<V>& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
template <class V>
HWY_INLINE Vector3<V> Cross(const Vector3<V>& a, const Vector3<V>& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
template <class V>
HWY_INLINE Vector3<V> Scaled(const Vector3<V>& a, const V s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
/// a + s b
template <class V>
HWY_INLINE Vector3<V> PlusScaled(const Vector3<V>& a, const V s, const Vector3<V>& b) {
  return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
/// a - s b
template <class V>
HWY_INLINE Vector3<V> MinusScaled(const Vector3<V>& a, const V s, const Vector3<V>& b) {
  return {hn::NegMulAdd(s, b.x, a.x), hn::NegMulAdd(s, b.y, a.y), hn::NegMulAdd(s, b.z, a.z)};
}
template <class V>
HWY_INLINE Vector3<V> Minus(const Vector3<V>& a, const Vector3<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

/// A batch of contacts of a with b.
template <class V>
struct Contact {
  V overlap;             ///< positive where touching
  Vector3<V> normal;     ///< from b to a
  Vector3<V> velocity;   ///< of a relative to b at the contact point
  Vector3<V> spin;       ///< angular velocity of a minus that of b
  V mean_spin;           ///< mean of the two angular velocities along the normal
  V radius;              ///< equivalent
  V stiffness, damping;  ///< k_n, c_d
  V shear_ratio, shear_ratio_root, friction, rolling, cohesion;
};

template <class V>
struct ContactHistoryVector {
  Vector3<V> shear;
  V overlap;
  Vector3<V> rolling;
};

template <class V>
struct ContactResponse {
  Vector3<V> force;   ///< on a
  Vector3<V> torque;  ///< on a beside that of the force; the opposite on b
  V pressure;         ///< magnitude of the normal force
  V damping_normal;   ///< damping part of the normal force along the normal
};

/// `spring` turned so that it is perpendicular to `normal`, its length kept, then turned with the spin about
/// the normal.
template <class V>
HWY_INLINE Vector3<V> TurnedWithNormal(const Vector3<V>& spring, const Vector3<V>& normal, const V turn,
                                       const V shorten) {
  const hn::DFromV<V> d;
  const V along = Dot(spring, normal);
  const Vector3<V> flat = MinusScaled(spring, along, normal);
  const V before = Dot(spring, spring);
  const V after = hn::Max(Dot(flat, flat), hn::Set(d, 1e-30F));
  const V scale = hn::Sqrt(hn::Div(hn::Mul(before, shorten), after));
  const Vector3<V> kept = Scaled(flat, scale);
  return PlusScaled(kept, turn, Cross(normal, kept));
}

/// Forces and the new history. Lanes that do not touch give zeros and lose their history.
template <bool kRolling, bool kCohesion, class V>
HWY_INLINE ContactResponse<V> EvaluateContact(const Contact<V>& c, const V dt, const V one_over_dt,
                                              ContactHistoryVector<V>& history) {
  const hn::DFromV<V> d;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0F);
  const V overlap = hn::Max(c.overlap, zero);
  const auto touching = hn::Gt(c.overlap, zero);
  const V root = hn::Sqrt(overlap);
  const V elastic_over_overlap = hn::Mul(c.stiffness, root);
  const V normal_stiffness = hn::Mul(hn::Set(d, 1.5F), elastic_over_overlap);
  const V damping = hn::Mul(c.damping, hn::Sqrt(normal_stiffness));

  const V normal_velocity = Dot(c.velocity, c.normal);
  const V damping_normal = hn::Neg(hn::Mul(damping, normal_velocity));
  const V contact_force = hn::MulAdd(elastic_over_overlap, overlap, damping_normal);
  V normal_force = contact_force;
  if constexpr (kCohesion) {
    // Simplified JKR: energy density times the area of the contact circle, pi (2 R_eq) overlap.
    const V area = hn::Mul(hn::Set(d, 6.2831853F), hn::Mul(c.radius, overlap));
    normal_force = hn::NegMulAdd(c.cohesion, area, normal_force);
  }

  const V safe_overlap = hn::Max(overlap, hn::Set(d, 1e-20F));
  const V shorten = hn::Min(one, hn::Div(history.overlap, safe_overlap));
  const V turn = hn::Mul(c.mean_spin, dt);
  const Vector3<V> spring = TurnedWithNormal(history.shear, c.normal, turn, shorten);
  const Vector3<V> tangential_velocity = MinusScaled(c.velocity, normal_velocity, c.normal);
  const V shear_stiffness = hn::Mul(c.shear_ratio, normal_stiffness);
  const V shear_damping = hn::Mul(c.shear_ratio_root, damping);
  // -F_t while sticking: S_t (xi + v dt) + c_t v.
  const V stick_velocity = hn::MulAdd(shear_stiffness, dt, shear_damping);
  const Vector3<V> trial = PlusScaled(Scaled(spring, shear_stiffness), stick_velocity, tangential_velocity);
  const V limit = hn::Mul(c.friction, hn::Max(contact_force, zero));
  const V trial_squared = Dot(trial, trial);
  const V scale = hn::Min(one, hn::Div(limit, hn::Sqrt(hn::Max(trial_squared, hn::Set(d, 1e-30F)))));
  const Vector3<V> drag = Scaled(trial, scale);
  // S_t xi' + c_t (xi' - xi) / dt = drag gives xi' = (drag + (c_t / dt) xi) / (S_t + c_t / dt).
  const V rate = hn::Mul(shear_damping, one_over_dt);
  const V inverse = hn::Div(one, hn::Max(hn::Add(shear_stiffness, rate), hn::Set(d, 1e-20F)));
  const Vector3<V> stretched = Scaled(PlusScaled(drag, rate, spring), inverse);

  ContactResponse<V> response;
  response.force = MinusScaled(Scaled(c.normal, normal_force), one, drag);
  response.torque = {zero, zero, zero};
  if constexpr (kRolling) {
    // Rolling spring of stiffness k_r = 2.25 k_n (mu_r R)^2 with k_n the secant stiffness of the contact, the
    // moment limited to mu_r R F_n.
    const V arm = hn::Mul(c.rolling, c.radius);
    const V rolling_stiffness = hn::Mul(hn::Set(d, 2.25F), hn::Mul(elastic_over_overlap, hn::Mul(arm, arm)));
    const V rolling_limit = hn::Mul(arm, hn::Max(contact_force, zero));
    const Vector3<V> turned = TurnedWithNormal(history.rolling, c.normal, turn, one);
    const Vector3<V> rolling_rate = MinusScaled(c.spin, Dot(c.spin, c.normal), c.normal);
    const Vector3<V> angle = PlusScaled(turned, dt, rolling_rate);
    const Vector3<V> moment = Scaled(angle, rolling_stiffness);
    const V moment_size = hn::Sqrt(hn::Max(Dot(moment, moment), hn::Set(d, 1e-38F)));
    const V factor = hn::Min(one, hn::Div(rolling_limit, moment_size));
    const Vector3<V> kept = Scaled(angle, factor);
    const Vector3<V> torque = Scaled(moment, hn::Neg(factor));
    response.torque = {hn::IfThenElseZero(touching, torque.x), hn::IfThenElseZero(touching, torque.y),
                       hn::IfThenElseZero(touching, torque.z)};
    history.rolling = {hn::IfThenElseZero(touching, kept.x), hn::IfThenElseZero(touching, kept.y),
                       hn::IfThenElseZero(touching, kept.z)};
  }
  response.force = {hn::IfThenElseZero(touching, response.force.x),
                    hn::IfThenElseZero(touching, response.force.y),
                    hn::IfThenElseZero(touching, response.force.z)};
  response.pressure = hn::IfThenElseZero(touching, hn::Abs(normal_force));
  response.damping_normal = hn::IfThenElseZero(touching, damping_normal);
  history.shear = {hn::IfThenElseZero(touching, stretched.x), hn::IfThenElseZero(touching, stretched.y),
                   hn::IfThenElseZero(touching, stretched.z)};
  history.overlap = overlap;
  return response;
}

}  // namespace wheel_twin::dem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
