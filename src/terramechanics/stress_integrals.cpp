#include "terramechanics/stress_integrals.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace wheel_twin::terramechanics {
namespace {

// Gauss-Legendre, 12 nodes on [-1, 1] (Abramowitz and Stegun, Table 25.4).
constexpr std::array<double, 6> kNode = {0.12523340851146891, 0.36783149899818018, 0.58731795428661748,
                                         0.76990267419430469, 0.9041172563704748,  0.98156063424671924};
constexpr std::array<double, 6> kWeight = {0.24914704581340269, 0.23349253653835464, 0.20316742672306565,
                                           0.16007832854334611, 0.10693932599531888, 0.047175336386512022};
constexpr double kSaturated = 40.0;   // exp(-40) is nothing
constexpr double kSteep = 2.0;        // change of |j| / K that one piece resolves, half of it when braking
constexpr double kTolerance = 1e-10;  // of the adaptive pieces, relative

/// Running sums over theta of what contact_loads() returns, without the factors b and R.
struct Sums {
  double sigma_cos = 0.0, sigma_sin = 0.0;
  double tau_cos = 0.0, tau_sin = 0.0, tau = 0.0;
  double side = 0.0, side_cos = 0.0, side_sin = 0.0;
  double grouser = 0.0, grouser_torque = 0.0;
  double wall = 0.0, wall_moment_x = 0.0, wall_moment_z = 0.0;

  template <class F>
  void combine(const Sums& o, F f) {
    f(sigma_cos, o.sigma_cos), f(sigma_sin, o.sigma_sin);
    f(tau_cos, o.tau_cos), f(tau_sin, o.tau_sin), f(tau, o.tau);
    f(side, o.side), f(side_cos, o.side_cos), f(side_sin, o.side_sin);
    f(grouser, o.grouser), f(grouser_torque, o.grouser_torque);
    f(wall, o.wall), f(wall_moment_x, o.wall_moment_x), f(wall_moment_z, o.wall_moment_z);
  }
  void operator+=(const Sums& o) {
    combine(o, [](double& a, double b) { a += b; });
  }
};

/// Thrust of the grousers a metre of rim (paper, F_g): at the surface, and its growth with depth.
struct GrouserStrength {
  double at_surface = 0.0, with_depth = 0.0;
};

GrouserStrength grouser_strength(double R, const ContactLaw& law) {
  const double root = std::tan(0.25 * M_PI + 0.5 * std::atan(law.tan_phi));  // sqrt(N_phi)
  const double h = law.grouser_height;
  const double line = law.grousers / (2.0 * M_PI * R);  // grousers a metre of rim
  return {line * (0.5 * law.weight_density * h * h * root * root + 2.0 * law.c * h * root),
          line * law.weight_density * h * root * root};
}

/// A place on the contact.
struct Point {
  double zeta;      // depth that carries the normal stress, m
  double sin, cos;  // of theta
  double J_x, J_y;  // shear displacement times rolling / R
};

/// One run of theta over which the stress formulas do not change. t = 0 is the end where the normal stress
/// vanishes.
enum class Arc { front, mirrored };
struct Segment {
  Arc arc;
  double length;      // of the whole graded run t = 0 to 1, rad
  double t0, t1;      // the part of it that belongs to the segment
  double flattening;  // theta_d - sin(theta_d), twice, where the flat patch has been passed
};

template <bool Full>
class Integrator {
 public:
  Integrator(const ContactGeometry& g, const RimMotion& m, const ContactLaw& law)
      : g_(g), m_(m), law_(law), a_(std::max(m.rolling, 1e-30)), steering_(m.sideways != 0.0) {
    scale_ = g.R / (a_ * law.K);
    sin_1_ = std::sin(g.theta_1), cos_1_ = std::cos(g.theta_1);
    sin_2_ = std::sin(g.theta_2), cos_2_ = std::cos(g.theta_2);
    sin_d_ = std::sin(g.theta_d), cos_d_ = std::cos(g.theta_d);
    if (g.theta_m > g.theta_2) mirror_ = (g.theta_1 - g.theta_m) / (g.theta_m - g.theta_2);
    if constexpr (Full) {
      set_grousers(grouser_strength(g.R, law));
      if (steering_) {
        const double phi = std::atan(law.tan_phi);
        const double cot_x =
            std::tan(0.25 * M_PI + 0.5 * phi);  // cot of the destructive angle 45 deg - phi / 2
        const double d_1 = cot_x + std::tan(0.25 * M_PI + 0.5 * phi);
        const double d_2 = cot_x + cot_x * cot_x * law.tan_phi;
        wall_c_ = d_1 * law.c;
        wall_w_ = 0.5 * d_1 * d_2 * law.weight_density;
      }
    }
  }

  void set_grousers(const GrouserStrength& strength) {
    grouser_0_ = strength.at_surface;
    grouser_z_ = strength.with_depth;
  }

  Sums run() {
    // The wheel brakes: shear may reverse, with a kink in tau there, and turns around where the slip velocity
    // is zero. Near zero slip the displacement has an inflection under the hub.
    if (m_.forward > a_) find_turns();
    if (m_.forward > 0.8 * a_ && m_.forward <= a_) turns_[turn_count_++] = 0.0;
    if (steering_) set_limits();
    const double rear_all = g_.theta_m - g_.theta_2;
    const double front_from = std::max(g_.theta_d, g_.theta_m);
    const double front = g_.theta_m > g_.theta_d ? g_.theta_1 - g_.theta_m : g_.front;
    if (front > 0.0) segment({Arc::front, front, 0.0, 1.0, 0.0}, g_.theta_1, front_from);
    const double flattening = 2.0 * (g_.theta_d - sin_d_);
    if (g_.theta_d == 0.0) {
      if (rear_all > 0.0) segment({Arc::mirrored, rear_all, 0.0, 1.0, 0.0}, g_.theta_2, g_.theta_m);
    } else {
      if (g_.rear > 0.0) {
        const double t = std::cbrt(std::min(1.0, g_.rear / rear_all));
        segment({Arc::mirrored, rear_all, 0.0, t, flattening}, g_.theta_2, -g_.theta_d);
      }
      if (g_.theta_m > g_.theta_d) {
        const double t = std::cbrt(std::min(1.0, (g_.theta_d - g_.theta_2) / rear_all));
        segment({Arc::mirrored, rear_all, t, 1.0, 0.0}, g_.theta_d, g_.theta_m);
      }
      flat();
    }
    return sums_;
  }

 private:
  double pressure(double zeta) const {
    const double power = law_.n == 1.0 ? zeta : zeta > 0.0 ? std::pow(zeta, law_.n) : 0.0;
    const double sigma = law_.k_eq * power;
    return law_.factor ? sigma * (*law_.factor)(zeta) : sigma;
  }

  Point point(const Segment& s, double t) const {
    Point p{};
    const double along = s.length * t * t * t;
    double u, less;  // theta_1 - theta, and sin(theta_1) - sin(theta)
    if (s.arc == Arc::front) {
      u = along;
      const double sh = std::sin(0.5 * u), ch = std::cos(0.5 * u);
      const double sin_u = 2.0 * sh * ch, versine = 2.0 * sh * sh;
      p.zeta = std::max(0.0, g_.R * (sin_1_ * sin_u - cos_1_ * versine));
      less = sin_1_ * versine + cos_1_ * sin_u;
      p.sin = sin_1_ - less;
      p.cos = cos_1_ * (1.0 - versine) + sin_1_ * sin_u;
    } else {
      const double image = mirror_ * along;
      const double sh = std::sin(0.5 * image), ch = std::cos(0.5 * image);
      p.zeta = std::max(0.0, g_.R * 2.0 * sh * (sin_1_ * ch - cos_1_ * sh));
      const double sin_w = std::sin(along), cos_w = std::cos(along);
      p.sin = sin_2_ * cos_w + cos_2_ * sin_w;
      p.cos = cos_2_ * cos_w - sin_2_ * sin_w;
      u = g_.theta_1 - g_.theta_2 - along;
      less = sin_1_ - p.sin;
    }
    p.J_x = a_ * (u - s.flattening) - m_.forward * less;
    p.J_y = m_.sideways * (u - s.flattening);
    return p;
  }

  double exponent(const Point& p) const {
    return scale_ * (steering_ ? std::hypot(p.J_x, p.J_y) : std::abs(p.J_x));
  }

  /// Adds the stresses at a point, `w` the weight in theta (or in x / R on the flat patch, where cos stands
  /// for that).
  void add(const Point& p, double w, double along_x, Sums& sums) const {
    const double sigma = pressure(p.zeta);
    const double J = steering_ ? std::hypot(p.J_x, p.J_y) : std::abs(p.J_x);
    const double mobilised = -std::expm1(-std::min(scale_ * J, 700.0));
    const double strength = (law_.c + sigma * law_.tan_phi) * mobilised;
    const double tau_x = steering_ ? (J > 0.0 ? strength * p.J_x / J : 0.0) : std::copysign(strength, p.J_x);
    sums.sigma_cos += w * sigma * p.cos;
    sums.tau_sin += w * tau_x * p.sin;
    if constexpr (Full) {
      sums.sigma_sin += w * sigma * p.sin;
      sums.tau_cos += w * tau_x * p.cos;
      sums.tau += w * tau_x;
      const double depth =
          std::max(0.0, g_.R * (p.cos - cos_1_));  // of the rim below the undisturbed surface
      const double pushed =
          steering_ ? (J > 0.0 ? mobilised * p.J_x / J : 0.0) : std::copysign(mobilised, p.J_x);
      const double thrust = (grouser_0_ + grouser_z_ * depth) * pushed;
      sums.grouser += w * thrust;
      sums.grouser_torque += w * thrust * p.cos;
      if (steering_ && J > 0.0) {
        const double tau_y = strength * p.J_y / J;
        sums.side += w * tau_y;
        sums.side_cos += w * tau_y * p.cos;
        sums.side_sin += w * tau_y * p.sin;
        const double moved = -std::expm1(-std::min(scale_ * std::abs(p.J_y), 700.0));
        const double wall = std::copysign((wall_c_ + wall_w_ * depth) * depth * moved, p.J_y) * along_x;
        sums.wall += w * wall;
        sums.wall_moment_x += w * wall * (g_.R * cos_1_ + 2.0 / 3.0 * depth);
        sums.wall_moment_z += w * wall * g_.R * p.sin;
      }
    }
  }

  Sums rule(const Segment& s, double t0, double t1) const {
    Sums sums;
    const double middle = 0.5 * (t0 + t1), half = 0.5 * (t1 - t0);
    for (std::size_t i = 0; i < kNode.size(); ++i) {
      for (const double sign : {-1.0, 1.0}) {
        const double t = middle + sign * half * kNode[i];
        const Point p = point(s, t);
        add(p, kWeight[i] * half * 3.0 * s.length * t * t, p.cos, sums);
      }
    }
    return sums;
  }

  void piece(const Segment& s, double t0, double t1, int depth) {
    const double e0 = std::min(kSaturated, exponent(point(s, t0)));
    const double e1 = std::min(kSaturated, exponent(point(s, t1)));
    // What is left of exp(-|j| / K) has weight exp(-min(e0, e1)): the tail may be coarse.
    const double resolved = (m_.forward > a_ ? 0.5 : 1.0) * kSteep * (1.0 + 0.25 * std::min(e0, e1));
    if (std::abs(e1 - e0) > resolved && depth < 40) {
      const double middle = 0.5 * (t0 + t1);
      piece(s, t0, middle, depth + 1);
      piece(s, middle, t1, depth + 1);
    } else if (steering_) {
      sums_ += adaptive(s, t0, t1, rule(s, t0, t1), 0);
    } else {
      sums_ += rule(s, t0, t1);
    }
  }

  /// Near the reversal of a braked and steered wheel the direction of j turns quickly: halve until it is
  /// resolved.
  Sums adaptive(const Segment& s, double t0, double t1, const Sums& whole, int depth) const {
    const double middle = 0.5 * (t0 + t1);
    const Sums left = rule(s, t0, middle), right = rule(s, middle, t1);
    Sums both = left;
    both += right;
    if (agree(both, whole) || depth > 30) return both;
    Sums refined = adaptive(s, t0, middle, left, depth + 1);
    refined += adaptive(s, middle, t1, right, depth + 1);
    return refined;
  }

  /// Largest error of each sum that adaptive() lets pass.
  void set_limits() {
    const double arc = kTolerance * (g_.theta_1 - g_.theta_2);
    const double strength = law_.c + pressure(g_.z) * (1.0 + law_.tan_phi);
    limit_.sigma_cos = limit_.sigma_sin = limit_.tau_cos = limit_.tau_sin = limit_.tau = arc * strength;
    limit_.side = limit_.side_cos = limit_.side_sin = arc * strength;
    limit_.grouser = limit_.grouser_torque = arc * (grouser_0_ + grouser_z_ * g_.z);
    limit_.wall = arc * (wall_c_ + wall_w_ * g_.z) * g_.z;
    limit_.wall_moment_x = limit_.wall_moment_z = limit_.wall * g_.R;
  }

  bool agree(const Sums& a, const Sums& b) const {
    Sums difference = a;
    difference.combine(b, [](double& x, double y) { x -= y; });
    bool good = true;
    difference.combine(limit_, [&](double& x, double y) { good = good && std::abs(x) <= y; });
    return good;
  }

  double J_at(double theta, double flattening) const {
    return a_ * (g_.theta_1 - theta - flattening) - m_.forward * (sin_1_ - std::sin(theta));
  }

  /// Bisection with secant steps; J has opposite signs at the ends.
  double reversal(double lo, double hi, double flattening) const {
    double f_lo = J_at(lo, flattening), f_hi = J_at(hi, flattening);
    for (int i = 0; i < 80 && hi - lo > 1e-15; ++i) {
      double x = i % 3 == 2 ? 0.5 * (lo + hi) : lo - f_lo * (hi - lo) / (f_hi - f_lo);
      if (!(x > lo && x < hi)) x = 0.5 * (lo + hi);
      const double f = J_at(x, flattening);
      if (f == 0.0) return x;
      ((f > 0.0) == (f_hi > 0.0) ? (hi = x, f_hi = f) : (lo = x, f_lo = f));
    }
    return 0.5 * (lo + hi);
  }

  void find_turns() {
    const double flattening = 2.0 * (g_.theta_d - sin_d_);
    const double turn = std::acos(std::min(1.0, a_ / m_.forward));  // slip velocity is zero at +-turn
    turns_[turn_count_++] = turn;
    turns_[turn_count_++] = -turn;
    const auto look = [&](double lo, double hi, double flat) {
      if (!(lo < hi)) return;
      const double f_lo = J_at(lo, flat), f_hi = J_at(hi, flat);
      if (f_lo * f_hi < 0.0) turns_[turn_count_++] = reversal(lo, hi, flat);
    };
    look(g_.theta_d, std::min(turn, g_.theta_1), 0.0);
    look(std::max(g_.theta_2, -turn), std::min(-g_.theta_d, -0.0), flattening);
    look(g_.theta_2, std::min(-turn, -g_.theta_d), flattening);
  }

  /// `from` is the angle at the segment's t = 0 end of the graded run when t0 = 0, `to` at t1.
  void segment(const Segment& s, double from, double to) {
    std::array<double, 7> cut{};
    std::size_t cuts = 0;
    cut[cuts++] = s.t0;
    for (std::size_t i = 0; i < turn_count_; ++i) {
      const double theta = turns_[i];
      if (theta <= std::min(from, to) || theta >= std::max(from, to)) continue;
      const double along = s.arc == Arc::front ? g_.theta_1 - theta : theta - g_.theta_2;
      const double t = std::cbrt(along / s.length);
      if (!(t > s.t0 && t < s.t1)) continue;
      std::size_t place = cuts++;
      for (; cut[place - 1] > t; --place) cut[place] = cut[place - 1];
      cut[place] = t;
    }
    cut[cuts] = s.t1;
    for (std::size_t i = 0; i < cuts; ++i) piece(s, cut[i], cut[i + 1], 0);
  }

  /// Flat patch: constant normal stress, j linear in x (closed form without steering). Here w is dx / R.
  void flat() {
    const double sigma = pressure(g_.z);
    sums_.sigma_cos += 2.0 * sin_d_ * sigma;
    if constexpr (Full) {
      Point ends[2];
      for (int i = 0; i < 2; ++i) {
        const double x = i == 0 ? sin_d_ : -sin_d_;
        ends[i] = flat_point(x);
      }
      const double strength = law_.c + sigma * law_.tan_phi;
      const double grouser = grouser_0_ + grouser_z_ * g_.z;
      if (!steering_) {
        const double mobilised = 2.0 * sin_d_ * mean_mobilised(scale_ * ends[0].J_x, scale_ * ends[1].J_x);
        sums_.tau_cos += strength * mobilised;
        sums_.tau += strength * cos_d_ * mobilised;
        sums_.grouser += grouser * mobilised;
        sums_.grouser_torque += grouser * cos_d_ * mobilised;
        return;
      }
      flat_piece(-sin_d_, sin_d_, strength, grouser, 0);
    }
  }

  Point flat_point(double x) const {
    Point p{};
    p.zeta = g_.z;
    p.sin = x;
    p.cos = cos_d_;
    p.J_x = J_at(g_.theta_d, 0.0) + (a_ - m_.forward) * (sin_d_ - x);
    p.J_y = m_.sideways * (g_.front + sin_d_ - x);
    return p;
  }

  Sums flat_rule(double x0, double x1, double strength, double grouser) const {
    Sums sums;
    const double middle = 0.5 * (x0 + x1), half = 0.5 * (x1 - x0);
    for (std::size_t i = 0; i < kNode.size(); ++i) {
      for (const double sign : {-1.0, 1.0}) {
        const Point p = flat_point(middle + sign * half * kNode[i]);
        const double w = kWeight[i] * half;
        const double J = std::hypot(p.J_x, p.J_y);
        if (J == 0.0) continue;
        const double mobilised = -std::expm1(-std::min(scale_ * J, 700.0));
        const double x_share = mobilised * p.J_x / J, y_share = mobilised * p.J_y / J;
        sums.tau_cos += w * strength * x_share;
        sums.tau += w * strength * x_share * cos_d_;
        sums.grouser += w * grouser * x_share;
        sums.grouser_torque += w * grouser * x_share * cos_d_;
        sums.side += w * strength * y_share;
        sums.side_cos += w * strength * y_share * cos_d_;
        sums.side_sin += w * strength * y_share * p.sin;
        const double moved = -std::expm1(-std::min(scale_ * std::abs(p.J_y), 700.0));
        const double wall = std::copysign((wall_c_ + wall_w_ * g_.z) * g_.z * moved, p.J_y);
        sums.wall += w * wall;
        sums.wall_moment_x += w * wall * (g_.R * cos_1_ + 2.0 / 3.0 * g_.z);
        sums.wall_moment_z += w * wall * g_.R * p.sin;
      }
    }
    return sums;
  }

  void flat_piece(double x0, double x1, double strength, double grouser, int depth) {
    const double middle = 0.5 * (x0 + x1);
    const Sums whole = flat_rule(x0, x1, strength, grouser);
    Sums both = flat_rule(x0, middle, strength, grouser);
    both += flat_rule(middle, x1, strength, grouser);
    if (agree(both, whole) || depth > 30) {
      sums_ += both;
      return;
    }
    flat_piece(x0, middle, strength, grouser, depth + 1);
    flat_piece(middle, x1, strength, grouser, depth + 1);
  }

  /// Mean of sgn(e) (1 - exp(-|e|)) for e linear from e0 to e1.
  static double mean_mobilised(double e0, double e1) {
    if (e0 * e1 < 0.0) {
      const double share = e0 / (e0 - e1);
      return share * mean_mobilised(e0, 0.0) + (1.0 - share) * mean_mobilised(0.0, e1);
    }
    const double sign = e0 + e1 < 0.0 ? -1.0 : 1.0;
    const double low = std::min(std::abs(e0), std::abs(e1));
    const double rise = std::abs(e1 - e0);
    // 1 - exp(-low) mean(exp(-x), 0..rise), arranged so that small arguments lose nothing.
    const double mean = rise < 1e-4 ? 1.0 - rise * (0.5 - rise / 6.0) : -std::expm1(-rise) / rise;
    const double loss = rise < 1e-4 ? rise * (0.5 - rise / 6.0) : 1.0 - mean;
    return sign * (-std::expm1(-low) + std::exp(-low) * loss);
  }

  const ContactGeometry& g_;
  const RimMotion& m_;
  const ContactLaw& law_;
  double a_;
  bool steering_;
  double scale_ = 0.0, mirror_ = 0.0;
  double sin_1_, cos_1_, sin_2_, cos_2_, sin_d_, cos_d_;
  double grouser_0_ = 0.0, grouser_z_ = 0.0, wall_c_ = 0.0, wall_w_ = 0.0;
  std::array<double, 5> turns_{};
  std::size_t turn_count_ = 0;
  Sums sums_, limit_;
};

}  // namespace

double vertical_force(const ContactGeometry& geometry, const RimMotion& motion, const ContactLaw& law) {
  const Sums sums = Integrator<false>(geometry, motion, law).run();
  return law.b * geometry.R * (sums.sigma_cos + sums.tau_sin);
}

ContactLoads contact_loads(const ContactGeometry& geometry, const RimMotion& motion, const ContactLaw& law) {
  const Sums sums = Integrator<true>(geometry, motion, law).run();
  const double R = geometry.R, area = law.b * R;
  ContactLoads loads;
  loads.vertical = area * (sums.sigma_cos + sums.tau_sin);
  loads.thrust = area * sums.tau_cos;
  loads.compaction_resistance = area * sums.sigma_sin;
  loads.grouser_thrust = area * sums.grouser;
  loads.side_shear = area * sums.side;
  loads.bulldozing = R * sums.wall;
  const double arm = R + 0.5 * law.grouser_height;  // the wedge acts at half the grouser's height
  loads.torque = area * (R * sums.tau + arm * sums.grouser_torque);
  loads.moment_x = area * R * sums.side_cos + R * sums.wall_moment_x;
  loads.moment_z = area * R * sums.side_sin + R * sums.wall_moment_z;
  return loads;
}

LoadBasis load_basis(const ContactGeometry& geometry, const RimMotion& motion, const ContactLaw& law) {
  ContactLaw unit;
  unit.n = law.n;
  unit.K = law.K;
  unit.k_eq = 1.0;
  unit.tan_phi = 1.0;
  Integrator<true> frictional(geometry, motion, unit);
  frictional.set_grousers({0.0, 1.0});
  const Sums f = frictional.run();
  unit.k_eq = 0.0;
  unit.tan_phi = 0.0;
  unit.c = 1.0;
  Integrator<true> cohesive(geometry, motion, unit);
  cohesive.set_grousers({1.0, 0.0});
  const Sums c = cohesive.run();
  return {f.sigma_cos, f.sigma_sin, f.tau_cos, f.tau_sin,        f.tau,     c.tau_cos,
          c.tau_sin,   c.tau,       c.grouser, c.grouser_torque, f.grouser, f.grouser_torque};
}

double combined_vertical(const LoadBasis& basis, double radius, const ContactLaw& law) {
  return law.b * radius *
         (law.k_eq * (basis.pressure_cos + law.tan_phi * basis.friction_sin) + law.c * basis.cohesion_sin);
}

ContactLoads combined(const LoadBasis& basis, double radius, const ContactLaw& law) {
  const double area = law.b * radius, shear = law.k_eq * law.tan_phi;
  const GrouserStrength grouser = grouser_strength(radius, law);
  ContactLoads loads;
  loads.vertical = combined_vertical(basis, radius, law);
  loads.thrust = area * (shear * basis.friction_cos + law.c * basis.cohesion_cos);
  loads.compaction_resistance = area * law.k_eq * basis.pressure_sin;
  loads.grouser_thrust = area * (grouser.at_surface * basis.wedge + grouser.with_depth * basis.overburden);
  const double arm = radius + 0.5 * law.grouser_height;
  loads.torque =
      area * (radius * (shear * basis.friction + law.c * basis.cohesion) +
              arm * (grouser.at_surface * basis.wedge_torque + grouser.with_depth * basis.overburden_torque));
  return loads;
}

double static_vertical_force(const ContactGeometry& geometry, const ContactLaw& law) {
  ContactLaw frictionless = law;
  frictionless.c = 0.0;
  frictionless.tan_phi = 0.0;
  ContactGeometry front = geometry;
  front.theta_m = 0.0;
  front.theta_2 = -geometry.theta_1;
  front.rear = geometry.front;
  // With theta_m = 0 and theta_2 = -theta_1 the mirrored stress is the front's mirror image.
  return vertical_force(front, RimMotion{}, frictionless);
}

}  // namespace wheel_twin::terramechanics
