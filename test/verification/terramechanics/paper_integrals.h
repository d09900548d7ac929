// The paper's stresses written down as printed (Section 2, with the corrections of doc/physics.md) and
// integrated adaptively: an evaluation that shares nothing with the model's but the formulas.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "adaptive_quadrature.h"
#include "terramechanics/stress_integrals.h"

namespace wheel_twin {

struct PaperIntegrals {
  double R, b, theta_1, theta_2, theta_d, theta_m;
  double k_eq, n, c, tan_phi, K;
  double weight_density, grousers, h_g;
  double a, e_x, e_y;  // rim speed and travel, longitudinal and lateral, in units of the larger

  PaperIntegrals(const terramechanics::ContactGeometry& g, const terramechanics::RimMotion& m,
                 const terramechanics::ContactLaw& law)
      : R(g.R),
        b(law.b),
        theta_1(g.theta_1),
        theta_2(g.theta_2),
        theta_d(g.theta_d),
        theta_m(g.theta_m),
        k_eq(law.k_eq),
        n(law.n),
        c(law.c),
        tan_phi(law.tan_phi),
        K(law.K),
        weight_density(law.weight_density),
        grousers(law.grousers),
        h_g(law.grouser_height),
        a(m.rolling),
        e_x(m.forward),
        e_y(m.sideways) {}

  double sigma(double theta) const {
    double drop;
    if (theta >= theta_d) {
      drop = theta >= theta_m ? drop_of(theta) : mirrored(theta);
    } else if (theta >= -theta_d) {
      drop = drop_of(theta_d);
    } else {
      drop = mirrored(theta);
    }
    return k_eq * std::pow(R * std::max(0.0, drop), n);
  }
  double mirrored(double theta) const {
    return drop_of(theta_1 - (theta - theta_2) / (theta_m - theta_2) * (theta_1 - theta_m));
  }
  /// cos(theta) - cos(theta_1), free of cancellation.
  double drop_of(double theta) const {
    return 2.0 * std::sin(0.5 * (theta_1 + theta)) * std::sin(0.5 * (theta_1 - theta));
  }

  /// Rim path and travel between entry and theta, over R: their difference is j, weighted by the speeds.
  double rim_path(double theta) const {
    if (theta >= theta_d) return theta_1 - theta;
    if (theta >= -theta_d) return theta_1 - theta_d + std::sin(theta_d) - std::sin(theta);
    return theta_1 - theta_d + 2.0 * std::sin(theta_d) - theta_d - theta;
  }
  double j_x(double theta) const {
    return R / a * (a * rim_path(theta) - e_x * (std::sin(theta_1) - std::sin(theta)));
  }
  double j_y(double theta) const { return R / a * e_y * rim_path(theta); }
  double j(double theta) const { return std::hypot(j_x(theta), j_y(theta)); }
  double mobilised(double displacement) const { return -std::expm1(-displacement / K); }
  double tau(double theta) const { return (c + sigma(theta) * tan_phi) * mobilised(j(theta)); }
  double share_x(double theta) const { return j(theta) > 0.0 ? j_x(theta) / j(theta) : 0.0; }
  double share_y(double theta) const { return j(theta) > 0.0 ? j_y(theta) / j(theta) : 0.0; }
  double depth(double theta) const { return R * drop_of(std::max(std::abs(theta), theta_d)); }
  /// Passive thrust of one grouser at theta, N.
  double grouser(double theta) const {
    const double N_phi = std::pow(std::tan(M_PI / 4.0 + 0.5 * std::atan(tan_phi)), 2);
    const double q = weight_density * depth(theta);
    return b *
           (0.5 * weight_density * h_g * h_g * N_phi + q * h_g * N_phi + 2.0 * c * h_g * std::sqrt(N_phi));
  }
  /// Hegedus' resistance of the side wall, N/m.
  double bulldozing(double theta) const {
    const double phi = std::atan(tan_phi), X_c = M_PI / 4.0 - 0.5 * phi;
    const double D_1 = 1.0 / std::tan(X_c) + std::tan(X_c + phi);
    const double D_2 = 1.0 / std::tan(X_c) + tan_phi / (std::tan(X_c) * std::tan(X_c));
    const double h = depth(theta);
    return D_1 * (c * h + 0.5 * D_2 * weight_density * h * h);
  }

  /// f over the arcs (d theta) and g over the patch (x = R sin theta, dx / R = cos theta d theta), to 1e-11
  /// of the integral of the absolute value. Kinks are cut apart.
  template <class F, class G>
  Quadrature over_contact(const F& f, const G& g) const {
    const double front = std::max(theta_d, theta_m);
    // Shear builds up within a hair of the entry when the wheel is nearly locked: grade towards it.
    std::vector<double> cuts = {theta_1};
    for (int i = -7; i < 0; ++i) cuts.push_back(theta_1 - std::pow(10.0, i) * (theta_1 - front));
    cuts.push_back(front);
    if (theta_m > theta_d) cuts.push_back(theta_d);
    // Where the shear reverses tau has a kink.
    std::vector<double> reversals;
    for (int i = 0; i < 200; ++i) {
      double lo = theta_2 + (theta_1 - theta_2) * i / 200.0,
             hi = theta_2 + (theta_1 - theta_2) * (i + 1) / 200.0;
      if (j_x(lo) * j_x(hi) >= 0.0) continue;
      for (int k = 0; k < 60; ++k)
        ((j_x(lo) > 0.0) == (j_x(0.5 * (lo + hi)) > 0.0) ? lo : hi) = 0.5 * (lo + hi);
      reversals.push_back(lo);
    }
    const auto patch = [&](double theta) { return g(theta) * std::cos(theta); };
    double magnitude = rough_magnitude(patch, -theta_d, theta_d) + rough_magnitude(f, theta_2, -theta_d);
    for (std::size_t i = 1; i < cuts.size(); ++i) magnitude += rough_magnitude(f, cuts[i], cuts[i - 1]);
    const double error = 1e-11 * magnitude;
    Quadrature sum;
    if (error == 0.0) return sum;
    const auto add = [&](Quadrature q) { sum.value += q.value, sum.magnitude += q.magnitude; };
    const auto add_cut = [&](const auto& h, double lo, double hi) {
      for (const double theta : reversals) {
        if (!(theta > lo && theta < hi)) continue;
        add(integrate(h, lo, theta, error));
        lo = theta;
      }
      add(integrate(h, lo, hi, error));
    };
    for (std::size_t i = 1; i < cuts.size(); ++i) add_cut(f, cuts[i], cuts[i - 1]);
    add_cut(f, theta_2, -theta_d);
    add_cut(patch, -theta_d, theta_d);
    return sum;
  }
};

}  // namespace wheel_twin
