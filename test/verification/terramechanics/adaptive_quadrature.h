// Adaptive Gauss-Kronrod quadrature (7 and 15 nodes, QUADPACK's qk15): the yardstick for the model's fixed
// nodes.
#pragma once

#include <array>
#include <cmath>

namespace wheel_twin {

struct Quadrature {
  double value = 0.0;
  double magnitude = 0.0;  ///< integral of the absolute value
};

namespace detail {

inline constexpr std::array<double, 8> kKronrodNode = {
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
    0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
    0.586087235467691130294144691693013, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.0};
inline constexpr std::array<double, 8> kKronrodWeight = {
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
    0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
    0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
inline constexpr std::array<double, 4> kGaussWeight = {
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
    0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

template <class F>
Quadrature kronrod(const F& f, double a, double b, double& error) {
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  Quadrature q;
  double gauss = 0.0;
  for (std::size_t i = 0; i < 8; ++i) {
    const int sides = i == 7 ? 1 : 2;
    for (int side = 0; side < sides; ++side) {
      const double y = f(middle + (side == 0 ? half : -half) * kKronrodNode[i]);
      q.value += half * kKronrodWeight[i] * y;
      q.magnitude += std::abs(half) * kKronrodWeight[i] * std::abs(y);
      if (i % 2 == 1) gauss += half * kGaussWeight[i / 2] * y;
    }
  }
  error = std::abs(q.value - gauss);
  return q;
}

template <class F>
Quadrature refine(const F& f, double a, double b, double tolerance, int depth) {
  double error = 0.0;
  const Quadrature q = kronrod(f, a, b, error);
  if (error <= tolerance || depth == 0) return q;
  const double middle = 0.5 * (a + b);
  const Quadrature left = refine(f, a, middle, 0.7 * tolerance, depth - 1);
  const Quadrature right = refine(f, middle, b, 0.7 * tolerance, depth - 1);
  return {left.value + right.value, left.magnitude + right.magnitude};
}

}  // namespace detail

/// Integral of f from a to b, bisected until the error of every part is below its share of `error`
/// (absolute).
template <class F>
Quadrature integrate(const F& f, double a, double b, double error) {
  return a < b ? detail::refine(f, a, b, error, 45) : Quadrature{};
}

/// Integral of |f| from one application of the rule: a yardstick for `error` above.
template <class F>
double rough_magnitude(const F& f, double a, double b) {
  double error = 0.0;
  return a < b ? detail::kronrod(f, a, b, error).magnitude : 0.0;
}

}  // namespace wheel_twin
