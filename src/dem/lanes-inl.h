// Rows of 64 bytes (sphere rows, load rows) to vectors and back: on AVX-512 by whole loads and an 8 x 8
// transposition, elsewhere by gathers. Included once for every instruction set.
#if defined(WHEEL_TWIN_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef WHEEL_TWIN_LANES_INL_H
#undef WHEEL_TWIN_LANES_INL_H
#else
#define WHEEL_TWIN_LANES_INL_H
#endif

#include <hwy/highway.h>

#include "dem/contact_law-inl.h"
#include "dem/store.h"

HWY_BEFORE_NAMESPACE();
namespace wheel_twin::dem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kBatch>;
using DF = hn::Rebind<float, D>;
using DI = hn::Rebind<std::int64_t, D>;
using DU = hn::Rebind<std::uint64_t, D>;
using DFI = hn::Rebind<std::int32_t, DF>;
using DFU = hn::Rebind<std::uint32_t, DF>;
using VD = hn::Vec<D>;
using VF = hn::Vec<DF>;

#undef WHEEL_TWIN_ROWS
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
#define WHEEL_TWIN_ROWS 1
#else
#define WHEEL_TWIN_ROWS 0
#endif

/// A batch of sphere rows as vectors.
struct SphereLanes {
  Vector3<VD> x;
  Vector3<VF> v, w, lever;
  VF radius;
};

#if WHEEL_TWIN_ROWS
HWY_INLINE void Transpose(__m512d (&r)[8]) {
  const __m512d t0 = _mm512_unpacklo_pd(r[0], r[1]), t1 = _mm512_unpackhi_pd(r[0], r[1]);
  const __m512d t2 = _mm512_unpacklo_pd(r[2], r[3]), t3 = _mm512_unpackhi_pd(r[2], r[3]);
  const __m512d t4 = _mm512_unpacklo_pd(r[4], r[5]), t5 = _mm512_unpackhi_pd(r[4], r[5]);
  const __m512d t6 = _mm512_unpacklo_pd(r[6], r[7]), t7 = _mm512_unpackhi_pd(r[6], r[7]);
  const __m512d a0 = _mm512_shuffle_f64x2(t0, t2, 0x88), a1 = _mm512_shuffle_f64x2(t4, t6, 0x88);
  const __m512d b0 = _mm512_shuffle_f64x2(t0, t2, 0xDD), b1 = _mm512_shuffle_f64x2(t4, t6, 0xDD);
  const __m512d c0 = _mm512_shuffle_f64x2(t1, t3, 0x88), c1 = _mm512_shuffle_f64x2(t5, t7, 0x88);
  const __m512d d0 = _mm512_shuffle_f64x2(t1, t3, 0xDD), d1 = _mm512_shuffle_f64x2(t5, t7, 0xDD);
  r[0] = _mm512_shuffle_f64x2(a0, a1, 0x88);
  r[4] = _mm512_shuffle_f64x2(a0, a1, 0xDD);
  r[2] = _mm512_shuffle_f64x2(b0, b1, 0x88);
  r[6] = _mm512_shuffle_f64x2(b0, b1, 0xDD);
  r[1] = _mm512_shuffle_f64x2(c0, c1, 0x88);
  r[5] = _mm512_shuffle_f64x2(c0, c1, 0xDD);
  r[3] = _mm512_shuffle_f64x2(d0, d1, 0x88);
  r[7] = _mm512_shuffle_f64x2(d0, d1, 0xDD);
}
HWY_INLINE VF LowFloats(const __m512d column) {
  return VF{_mm256_castsi256_ps(_mm512_cvtepi64_epi32(_mm512_castpd_si512(column)))};
}
HWY_INLINE VF HighFloats(const __m512d column) {
  return VF{_mm256_castsi256_ps(_mm512_cvtepi64_epi32(_mm512_srli_epi64(_mm512_castpd_si512(column), 32)))};
}
HWY_INLINE __m512d Packed(const VF low, const VF high) {
  const __m512i l = _mm512_cvtepu32_epi64(_mm256_castps_si256(low.raw));
  const __m512i h = _mm512_cvtepu32_epi64(_mm256_castps_si256(high.raw));
  return _mm512_castsi512_pd(_mm512_or_si512(l, _mm512_slli_epi64(h, 32)));
}
#endif

HWY_INLINE SphereLanes LoadSpheres(const SphereRow* rows, const std::uint32_t* index) {
  SphereLanes s;
#if WHEEL_TWIN_ROWS
  __m512d r[8];
  for (std::size_t k = 0; k < 8; ++k) r[k] = _mm512_load_pd(reinterpret_cast<const double*>(rows + index[k]));
  Transpose(r);
  s.x = {VD{r[0]}, VD{r[1]}, VD{r[2]}};
  s.v = {LowFloats(r[3]), HighFloats(r[3]), LowFloats(r[4])};
  s.w = {HighFloats(r[4]), LowFloats(r[5]), HighFloats(r[5])};
  s.lever = {LowFloats(r[6]), HighFloats(r[6]), LowFloats(r[7])};
  s.radius = HighFloats(r[7]);
#else
  const D d;
  const DF df;
  const DI di;
  const DFI dfi;
  const auto place = hn::LoadU(DFU(), index);
  const auto f = hn::BitCast(dfi, hn::ShiftLeft<4>(place));
  const auto w = hn::PromoteTo(di, hn::BitCast(dfi, hn::ShiftLeft<3>(place)));
  const auto* doubles = reinterpret_cast<const double*>(rows);
  const auto* floats = reinterpret_cast<const float*>(rows);
  const auto wide = [&](int k) { return hn::GatherIndex(d, doubles + k, w); };
  const auto narrow = [&](int k) { return hn::GatherIndex(df, floats + k, f); };
  s.x = {wide(0), wide(1), wide(2)};
  s.v = {narrow(6), narrow(7), narrow(8)};
  s.w = {narrow(9), narrow(10), narrow(11)};
  s.lever = {narrow(12), narrow(13), narrow(14)};
  s.radius = narrow(15);
#endif
  return s;
}

/// Writes lane k to rows[index[k]] unless that is `nowhere`.
HWY_INLINE void StoreSpheres(const SphereLanes& s, SphereRow* rows, const std::uint32_t* index,
                             std::uint32_t nowhere) {
#if WHEEL_TWIN_ROWS
  __m512d r[8] = {s.x.x.raw,
                  s.x.y.raw,
                  s.x.z.raw,
                  Packed(s.v.x, s.v.y),
                  Packed(s.v.z, s.w.x),
                  Packed(s.w.y, s.w.z),
                  Packed(s.lever.x, s.lever.y),
                  Packed(s.lever.z, s.radius)};
  Transpose(r);
  for (std::size_t k = 0; k < 8; ++k) {
    if (index[k] != nowhere) _mm512_store_pd(reinterpret_cast<double*>(rows + index[k]), r[k]);
  }
#else
  const D d;
  const DF df;
  HWY_ALIGN double wide[3][kBatch];
  HWY_ALIGN float narrow[10][kBatch];
  hn::StoreU(s.x.x, d, wide[0]);
  hn::StoreU(s.x.y, d, wide[1]);
  hn::StoreU(s.x.z, d, wide[2]);
  const VF columns[10] = {s.v.x, s.v.y,     s.v.z,     s.w.x,     s.w.y,
                          s.w.z, s.lever.x, s.lever.y, s.lever.z, s.radius};
  for (int c = 0; c < 10; ++c) hn::StoreU(columns[c], df, narrow[c]);
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    if (index[k] == nowhere) continue;
    SphereRow& row = rows[index[k]];
    for (int c = 0; c < 3; ++c) {
      row.x[c] = wide[c][k];
      row.v[c] = narrow[c][k];
      row.w[c] = narrow[3 + c][k];
      row.lever[c] = narrow[6 + c][k];
    }
    row.radius = narrow[9][k];
  }
#endif
}

/// Adds lane k of (force, torque, pressure) to loads[index[k]].
HWY_INLINE void AddLoads(const Vector3<VD>& force, const Vector3<VD>& torque, const VD pressure,
                         LoadRow* loads, const std::uint32_t* index) {
#if WHEEL_TWIN_ROWS
  __m512d r[8] = {force.x.raw,  force.y.raw,  force.z.raw,  torque.x.raw,
                  torque.y.raw, torque.z.raw, pressure.raw, _mm512_setzero_pd()};
  Transpose(r);
  for (std::size_t k = 0; k < 8; ++k) {
    auto* p = reinterpret_cast<double*>(loads + index[k]);
    _mm512_store_pd(p, _mm512_add_pd(_mm512_load_pd(p), r[k]));
  }
#else
  const D d;
  HWY_ALIGN double column[7][kBatch];
  const VD columns[7] = {force.x, force.y, force.z, torque.x, torque.y, torque.z, pressure};
  for (int c = 0; c < 7; ++c) hn::StoreU(columns[c], d, column[c]);
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    LoadRow& row = loads[index[k]];
    for (int c = 0; c < 3; ++c) {
      row.force[c] += column[c][k];
      row.torque[c] += column[3 + c][k];
    }
    row.pressure += column[6][k];
  }
#endif
}

/// Loads of the bodies from `begin` on, which are cleared.
HWY_INLINE void TakeLoads(LoadRow* loads, Vector3<VD>& force, Vector3<VD>& torque) {
#if WHEEL_TWIN_ROWS
  __m512d r[8];
  for (std::size_t k = 0; k < 8; ++k) {
    auto* p = reinterpret_cast<double*>(loads + k);
    r[k] = _mm512_load_pd(p);
    _mm512_store_pd(p, _mm512_setzero_pd());
  }
  Transpose(r);
  force = {VD{r[0]}, VD{r[1]}, VD{r[2]}};
  torque = {VD{r[3]}, VD{r[4]}, VD{r[5]}};
#else
  const D d;
  HWY_ALIGN double column[6][kBatch];
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    for (int c = 0; c < 3; ++c) {
      column[c][k] = loads[k].force[c];
      column[3 + c][k] = loads[k].torque[c];
    }
    loads[k] = LoadRow{};
  }
  force = {hn::LoadU(d, column[0]), hn::LoadU(d, column[1]), hn::LoadU(d, column[2])};
  torque = {hn::LoadU(d, column[3]), hn::LoadU(d, column[4]), hn::LoadU(d, column[5])};
#endif
}

HWY_INLINE Vector3<VD> Wide(const Vector3<VF>& a) {
  const D d;
  return {hn::PromoteTo(d, a.x), hn::PromoteTo(d, a.y), hn::PromoteTo(d, a.z)};
}
HWY_INLINE Vector3<VF> Narrow(const Vector3<VD>& a) {
  const DF df;
  return {hn::DemoteTo(df, a.x), hn::DemoteTo(df, a.y), hn::DemoteTo(df, a.z)};
}
/// Rounded to the quantum of `magic`.
HWY_INLINE VD RoundedTo(const VD value, const VD magic) {
  return hn::Sub(hn::Add(value, magic), magic);
}
HWY_INLINE Vector3<VD> RoundedTo(const Vector3<VD>& a, const VD magic) {
  return {RoundedTo(a.x, magic), RoundedTo(a.y, magic), RoundedTo(a.z, magic)};
}

}  // namespace wheel_twin::dem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
