// The first x > 0 at which a force that rises from about 0 reaches a target. The force may dip below 0 first
// (cohesion on the rear of a wheel that hardly presses), may fall again after a peak, and may (a deep wheel
// in light skid) rise once more. Works in the logarithm of x, where a power law is a straight line; peaks
// narrower than half of x are not looked for.
#pragma once

#include <algorithm>
#include <cmath>

namespace wheel_twin::terramechanics {

struct Crossing {
  double x = 0.0, force = 0.0;  ///< where and what, if found
  bool found = false;
  double best_x = 0.0, best_force = 0.0;  ///< the largest force met
};

template <class Force>
class FirstCrossing {
 public:
  /// `growth`: exponent of the force in x, roughly.
  FirstCrossing(const Force& force, double target, double end, double growth)
      : force_(force), target_(target), end_(end), growth_(growth) {}

  /// `guess` within 0 to `end`. `look_below`: also search the whole range below the first bracket, for forces
  /// that may have a small peak before the main rise. The force is met to `tolerance` times the target.
  Crossing find(double guess, bool look_below, double tolerance) {
    if (!bracket(guess)) return result_;
    if (look_below) search_below();
    solve(tolerance);
    result_.found = true;
    return result_;
  }

 private:
  struct Point {
    double x = 0.0, f = 0.0;
  };

  Point at(double x) {
    const Point p{x, force_(x)};
    if (p.f > result_.best_force || result_.best_x == 0.0) result_.best_x = x, result_.best_force = p.f;
    return p;
  }

  double step_up(const Point& p) const {
    return p.f > 0.0 ? std::clamp(1.05 * std::pow(target_ / p.f, 1.0 / growth_), 1.01, 1.5) : 1.5;
  }

  /// From a point at or above the target down to one below.
  void descend(Point from) {
    high_ = from;
    for (;;) {
      low_ = at(high_.x * std::clamp(0.95 * std::pow(target_ / high_.f, 1.0 / growth_), 1e-3, 0.95));
      if (low_.f < target_ || low_.x < 1e-300) return;
      high_ = low_;
    }
  }

  /// low_ below the target, high_ at or above it, no crossing in between but one. False: the target is never
  /// reached.
  bool bracket(double guess) {
    Point before{}, mid = at(guess);
    if (mid.f >= target_) {
      descend(mid);
      return true;
    }
    while (mid.x < end_) {
      Point next = at(std::min(end_, mid.x * step_up(mid)));
      if (next.f >= target_) {
        low_ = mid, high_ = next;
        return true;
      }
      if (mid.f > 0.0 && next.f < mid.f) {  // a peak has been passed
        const Point resume = next;
        while (before.x == 0.0) {  // it may lie below the guess
          const Point lower = at(0.7 * mid.x);
          if (lower.f >= target_) {
            descend(lower);
            return true;
          }
          if (lower.f < mid.f) {
            before = lower;
          } else {
            next = mid, mid = lower;
          }
        }
        if (climb(before, mid, next)) return true;
        before = mid, mid = resume;
        continue;
      }
      before = mid, mid = next;
    }
    return climb(before, mid, mid);
  }

  /// Golden section for a peak between two points; stops as soon as the target is reached.
  bool climb(const Point& left, const Point& mid, const Point& right) {
    constexpr double kGolden = 0.6180339887498949;
    if (mid.f <= 0.0) return false;
    double a = left.x, b = right.x;
    Point p = at(b - kGolden * (b - a)), q = at(a + kGolden * (b - a));
    while (b - a > 1e-9 * b) {
      if (p.f >= target_ || q.f >= target_) {
        low_ = left, high_ = p.f >= target_ ? p : q;
        return true;
      }
      if (p.f < q.f) {
        a = p.x, p = q, q = at(a + kGolden * (b - a));
      } else {
        b = q.x, q = p, p = at(b - kGolden * (b - a));
      }
    }
    return false;
  }

  void search_below() {
    const double x = low_.x;
    Point previous{};
    for (int i = -45; i < 0; ++i) {
      const Point p = at(x * std::pow(1.5, i));
      if (p.f >= target_) {
        low_ = previous, high_ = p;
        return;
      }
      previous = p;
    }
  }

  /// Secant in the logarithms inside the bracket, halved when it lags.
  void solve(double tolerance) {
    Point older = low_, newer = high_;
    if (std::abs(low_.f - target_) < std::abs(high_.f - target_)) std::swap(older, newer);
    for (int i = 0; i < 200 && std::abs(newer.f - target_) > tolerance * target_; ++i) {
      double x = low_.x > 0.0 ? std::sqrt(low_.x * high_.x) : 0.5 * high_.x;
      if (older.f > 0.0 && newer.f > 0.0 && older.f != newer.f && older.x > 0.0 && i % 4 != 3) {
        const double slope = std::log(newer.x / older.x) / std::log(newer.f / older.f);
        const double guess = newer.x * std::exp(std::log(target_ / newer.f) * slope);
        if (guess > low_.x && guess < high_.x) x = guess;
      }
      if (!(x > low_.x && x < high_.x)) break;  // the bracket is one rounding wide
      older = newer;
      newer = at(x);
      (newer.f < target_ ? low_ : high_) = newer;
    }
    result_.x = newer.x;
    result_.force = newer.f;
  }

  const Force& force_;
  double target_, end_, growth_;
  Point low_, high_;
  Crossing result_;
};

}  // namespace wheel_twin::terramechanics
