#include "wheel/planar_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace wheel_twin::wheel {
namespace {

constexpr double kGapTolerance = 1.0e-14;  // m: joints closed to rounding
constexpr int kMaximumIterations = 30;
constexpr double kSmallTurn = 1.0e-4;  // rad: the series of correct_arms() are then exact to rounding

inline Vec2 turn(double cosine, double sine, Vec2 r) {
  return {cosine * r.x + sine * r.z, cosine * r.z - sine * r.x};
}

std::vector<std::array<int, 2>> joint_pairs(const std::vector<PlanarJoint>& joints) {
  std::vector<std::array<int, 2>> pairs;
  for (const PlanarJoint& joint : joints) pairs.push_back({joint.a, joint.b});
  return pairs;
}

}  // namespace

PlanarSystem::PlanarSystem(Parts parts)
    : parts_(std::move(parts)),
      bodies_(static_cast<int>(parts_.bodies.size())),
      solver_(joint_pairs(parts_.joints), bodies_) {
  for (const PlanarBody& body : parts_.bodies) {
    mass_.push_back(body.mass);
    inertia_.push_back(body.inertia);
  }
  mass_.push_back(parts_.hub_mass);
  inertia_.push_back(parts_.hub_inertia);
  for (int i = 0; i <= bodies_; ++i) {
    inverse_mass_.push_back(1.0 / mass_[i]);
    inverse_inertia_.push_back(1.0 / inertia_[i]);
  }
  const std::size_t n = bodies_ + 1;
  x_.resize(n);
  v_.resize(n);
  angle_.resize(n);
  rate_.resize(n);
  cosine_.resize(n);
  sine_.resize(n);
  turned_.resize(n);
  elastic_.resize(n);
  damping_.resize(n);
  external_.resize(n);
  previous_external_.resize(n);
  const std::size_t joints = parts_.joints.size();
  arms_.resize(2 * joints);
  old_arms_.resize(2 * joints);
  gaps_.resize(joints);
  warm_.resize(joints);
  for (const PlanarJoint& joint : parts_.joints) {
    const double angle_b = joint.b == bodies_ ? 0.0 : parts_.bodies[joint.b].angle;
    rest_angle_.push_back(angle_b - parts_.bodies[joint.a].angle);
  }
  for (const PlanarSpring& spring : parts_.springs) {
    const PlanarBody& body = parts_.bodies[spring.body];
    rest_point_.push_back(body.position + turn(std::cos(body.angle), std::sin(body.angle), spring.at_body));
  }
  place({});
}

void PlanarSystem::place(const PlanarPose& hub) {
  const double c = std::cos(hub.angle);
  const double s = std::sin(hub.angle);
  for (int i = 0; i < bodies_; ++i) {
    const PlanarBody& body = parts_.bodies[i];
    const Vec2 arm = turn(c, s, body.position);
    x_[i] = hub.position + arm;
    v_[i] = hub.velocity + hub.rate * perp(arm);
    angle_[i] = hub.angle + body.angle;
    rate_[i] = hub.rate;
  }
  x_[bodies_] = hub.position;
  v_[bodies_] = hub.velocity;
  angle_[bodies_] = hub.angle;
  rate_[bodies_] = hub.rate;
  std::fill(warm_.begin(), warm_.end(), Vec2{});
  clear_external();
  previous_half_step_ = 0.0;
  hub_impulse_ = {};
  dissipated_ = 0.0;
  turn_arms();
  factorize();
  elastic_forces();
}

void PlanarSystem::set_hub_free(std::array<bool, 3> free) {
  hub_free_ = free;
  factorize();
}

void PlanarSystem::shift(Vec2 distance, Vec2 velocity) {
  for (int i = 0; i <= bodies_; ++i) {
    x_[i] = x_[i] + distance;
    v_[i] = v_[i] + velocity;
  }
}

void PlanarSystem::clear_external() {
  std::fill(external_.begin(), external_.end(), PlanarForce{});
}

Vec2 PlanarSystem::arm(int body, Vec2 local) const {
  return turn(cosine_[body], sine_[body], local);
}

void PlanarSystem::turn_arms() {
  for (int i = 0; i <= bodies_; ++i) {
    sincos(angle_[i], &sine_[i], &cosine_[i]);
    turned_[i] = angle_[i];
  }
  place_arms();
}

void PlanarSystem::correct_arms() {
  for (int i = 0; i <= bodies_; ++i) {
    const double d = angle_[i] - turned_[i];
    if (std::abs(d) > kSmallTurn) {
      sincos(angle_[i], &sine_[i], &cosine_[i]);
    } else {
      const double d2 = d * d;
      const double dc = 1.0 - d2 * (0.5 - d2 / 24.0);
      const double ds = d * (1.0 - d2 / 6.0);
      const double c = cosine_[i] * dc - sine_[i] * ds;
      sine_[i] = sine_[i] * dc + cosine_[i] * ds;
      cosine_[i] = c;
    }
    turned_[i] = angle_[i];
  }
  place_arms();
}

void PlanarSystem::place_arms() {
  for (std::size_t j = 0; j < parts_.joints.size(); ++j) {
    const PlanarJoint& joint = parts_.joints[j];
    arms_[2 * j] = turn(cosine_[joint.a], sine_[joint.a], joint.at_a);
    arms_[2 * j + 1] = turn(cosine_[joint.b], sine_[joint.b], joint.at_b);
  }
}

double PlanarSystem::close_gaps() {
  double largest = 0.0;
  for (std::size_t j = 0; j < parts_.joints.size(); ++j) {
    const PlanarJoint& joint = parts_.joints[j];
    gaps_[j] = (x_[joint.a] - x_[joint.b]) + (arms_[2 * j] - arms_[2 * j + 1]);
    largest = std::max({largest, std::abs(gaps_[j].x), std::abs(gaps_[j].z)});
  }
  return largest;
}

void PlanarSystem::elastic_forces() {
  std::fill(elastic_.begin(), elastic_.end(), PlanarForce{});
  for (std::size_t j = 0; j < parts_.joints.size(); ++j) {
    const PlanarJoint& joint = parts_.joints[j];
    const double torque = joint.stiffness * (angle_[joint.b] - angle_[joint.a] - rest_angle_[j]);
    elastic_[joint.a].torque += torque;
    elastic_[joint.b].torque -= torque;
  }
  const int h = bodies_;
  for (std::size_t k = 0; k < parts_.springs.size(); ++k) {
    const PlanarSpring& spring = parts_.springs[k];
    const Vec2 r = arm(spring.body, spring.at_body);
    const Vec2 d = x_[spring.body] + r - x_[h];
    const Vec2 u = d - arm(h, rest_point_[k]);
    const Vec2 radial = arm(h, spring.direction);
    const Vec2 tangential = perp(radial);
    const Vec2 f =
        -spring.radial * dot(u, radial) * radial - spring.tangential * dot(u, tangential) * tangential;
    elastic_[spring.body].force = elastic_[spring.body].force + f;
    const double torque =
        -spring.turning * (angle_[spring.body] - angle_[h] - parts_.bodies[spring.body].angle);
    elastic_[spring.body].torque += dot(perp(r), f) + torque;
    elastic_[h].force = elastic_[h].force - f;
    elastic_[h].torque -= dot(perp(d), f) + torque;
  }
}

double PlanarSystem::damping_forces() {
  if (parts_.damping_time == 0.0) return 0.0;
  double power = 0.0;
  std::fill(damping_.begin(), damping_.end(), PlanarForce{});
  for (const PlanarJoint& joint : parts_.joints) {
    const double turning = rate_[joint.b] - rate_[joint.a];
    const double torque = parts_.damping_time * joint.stiffness * turning;
    power += torque * turning;
    damping_[joint.a].torque += torque;
    damping_[joint.b].torque -= torque;
  }
  const int h = bodies_;
  for (const PlanarSpring& spring : parts_.springs) {
    const Vec2 r = arm(spring.body, spring.at_body);
    const Vec2 d = x_[spring.body] + r - x_[h];
    const Vec2 rate = v_[spring.body] + rate_[spring.body] * perp(r) - v_[h] - rate_[h] * perp(d);
    const Vec2 radial = arm(h, spring.direction);
    const Vec2 tangential = perp(radial);
    const Vec2 f = -parts_.damping_time * (spring.radial * dot(rate, radial) * radial +
                                           spring.tangential * dot(rate, tangential) * tangential);
    damping_[spring.body].force = damping_[spring.body].force + f;
    const double turning = rate_[spring.body] - rate_[h];
    const double torque = -parts_.damping_time * spring.turning * turning;
    damping_[spring.body].torque += dot(perp(r), f) + torque;
    damping_[h].force = damping_[h].force - f;
    damping_[h].torque -= dot(perp(d), f) + torque;
    power -= dot(f, rate) + torque * turning;
  }
  return power;
}

PlanarPose PlanarSystem::rigid_reference() const {
  PlanarPose reference = pose(bodies_);
  if (hub_free_[0]) reference.velocity.x = 0.0;
  if (hub_free_[1]) reference.velocity.z = 0.0;
  if (hub_free_[2]) reference.rate = 0.0;
  return reference;
}

void PlanarSystem::kick(double half_step, double correction) {
  dissipated_ += half_step * damping_forces();
  const PlanarPose reference = rigid_reference();
  const int h = bodies_;
  for (int i = 0; i <= h; ++i) {
    Vec2 force = elastic_[i].force + damping_[i].force;
    double torque = elastic_[i].torque + damping_[i].torque;
    if (i == h) {
      hub_impulse_.force = hub_impulse_.force + half_step * force;
      hub_impulse_.torque += half_step * torque;
    }
    const double more = correction / half_step;
    force = force + external_[i].force + more * (external_[i].force - previous_external_[i].force);
    torque += external_[i].torque + more * (external_[i].torque - previous_external_[i].torque);
    Vec2 acceleration{force.x * inverse_mass_[i], force.z * inverse_mass_[i] - gravity_};
    double angular = torque * inverse_inertia_[i];
    if (relaxation_ > 0.0) {
      const Vec2 rigid = reference.velocity + reference.rate * perp(x_[i] - x_[h]);
      acceleration = acceleration - relaxation_ * (v_[i] - rigid);
      angular -= relaxation_ * (rate_[i] - reference.rate);
    }
    if (i < h || hub_free_[0]) v_[i].x += half_step * acceleration.x;
    if (i < h || hub_free_[1]) v_[i].z += half_step * acceleration.z;
    if (i < h || hub_free_[2]) rate_[i] += half_step * angular;
  }
}

void PlanarSystem::factorize() {
  if (parts_.joints.empty()) return;
  solver_.factorize(arms_, inverse_mass_, inverse_inertia_);
  border_.clear();
  border_direction_.clear();
  const bool hub_has_joints = std::any_of(parts_.joints.begin(), parts_.joints.end(),
                                          [this](const PlanarJoint& joint) { return joint.b == bodies_; });
  if (!hub_has_joints) return;
  std::vector<std::vector<Vec2>> u;
  for (int direction = 0; direction < 3; ++direction) {
    if (!hub_free_[direction]) continue;
    std::vector<Vec2> column(parts_.joints.size());
    for (std::size_t j = 0; j < column.size(); ++j) {
      if (parts_.joints[j].b != bodies_) continue;
      column[j] = direction == 0   ? Vec2{-1.0, 0.0}
                  : direction == 1 ? Vec2{0.0, -1.0}
                                   : -1.0 * perp(arms_[2 * j + 1]);
    }
    u.push_back(column);
    solver_.solve(column);
    border_.push_back(std::move(column));
    border_direction_.push_back(direction);
  }
  const std::size_t m = u.size();
  border_matrix_.assign(m * m, 0.0);
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t k = 0; k < m; ++k) {
      double sum = i != k ? 0.0 : border_direction_[i] == 2 ? inertia_[bodies_] : mass_[bodies_];
      for (std::size_t j = 0; j < u[i].size(); ++j) sum += dot(u[i][j], border_[k][j]);
      border_matrix_[i * m + k] = sum;
    }
  }
}

void PlanarSystem::solve(std::vector<Vec2>& s) {
  const std::size_t m = border_.size();
  std::array<double, 3> alpha{};
  if (m > 0) {
    // Woodbury: alpha = (M_hub + U^T A^-1 U)^-1 (A^-1 U)^T g
    std::vector<double> a = border_matrix_;
    for (std::size_t i = 0; i < m; ++i) {
      for (std::size_t j = 0; j < s.size(); ++j) alpha[i] += dot(border_[i][j], s[j]);
    }
    for (std::size_t i = 0; i < m; ++i) {
      for (std::size_t k = i + 1; k < m; ++k) {
        const double factor = a[k * m + i] / a[i * m + i];
        for (std::size_t c = i; c < m; ++c) a[k * m + c] -= factor * a[i * m + c];
        alpha[k] -= factor * alpha[i];
      }
    }
    for (std::size_t i = m; i-- > 0;) {
      for (std::size_t c = i + 1; c < m; ++c) alpha[i] -= a[i * m + c] * alpha[c];
      alpha[i] /= a[i * m + i];
    }
  }
  solver_.solve(s);
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t j = 0; j < s.size(); ++j) s[j] = s[j] - alpha[i] * border_[i][j];
  }
}

void PlanarSystem::constraint_impulse(const std::vector<Vec2>& s, double position_factor,
                                      double velocity_factor, bool moves) {
  const std::vector<Vec2>& arms = moves ? old_arms_ : arms_;
  const int h = bodies_;
  for (std::size_t j = 0; j < s.size(); ++j) {
    const PlanarJoint& joint = parts_.joints[j];
    for (int side = 0; side < 2; ++side) {
      const int i = side == 0 ? joint.a : joint.b;
      const double sign = side == 0 ? -1.0 : 1.0;
      const double turn_impulse = dot(perp(arms[2 * j + side]), s[j]);
      if (i == h) {
        hub_impulse_.force = hub_impulse_.force + velocity_factor * s[j];
        hub_impulse_.torque += velocity_factor * turn_impulse;
      }
      const double mx = sign * (i < h || hub_free_[0] ? inverse_mass_[i] : 0.0);
      const double mz = sign * (i < h || hub_free_[1] ? inverse_mass_[i] : 0.0);
      const double mi = sign * (i < h || hub_free_[2] ? inverse_inertia_[i] : 0.0) * turn_impulse;
      if (moves) {
        x_[i].x += position_factor * mx * s[j].x;
        x_[i].z += position_factor * mz * s[j].z;
        angle_[i] += position_factor * mi;
      }
      v_[i].x += velocity_factor * mx * s[j].x;
      v_[i].z += velocity_factor * mz * s[j].z;
      rate_[i] += velocity_factor * mi;
    }
  }
}

void PlanarSystem::step(double h, const PlanarPose& hub_at_end) {
  const int hub = bodies_;
  // Velocity Verlet wants the last step's second half-kick with the force at its end, which the caller knows
  // only now (a contact's, say): the difference is made up for here. Without it a contact spring would feed
  // energy.
  kick(0.5 * h, previous_half_step_);
  previous_external_ = external_;
  previous_half_step_ = 0.5 * h;
  // The hub moves along its prescription; in its free directions like any body.
  const PlanarPose before = pose(hub);
  if (!hub_free_[0]) v_[hub].x = (hub_at_end.position.x - before.position.x) / h;
  if (!hub_free_[1]) v_[hub].z = (hub_at_end.position.z - before.position.z) / h;
  if (!hub_free_[2]) rate_[hub] = (hub_at_end.angle - before.angle) / h;
  for (int i = 0; i <= hub; ++i) {
    x_[i] = x_[i] + h * v_[i];
    angle_[i] += h * rate_[i];
  }
  if (!hub_free_[0]) x_[hub].x = hub_at_end.position.x;
  if (!hub_free_[1]) x_[hub].z = hub_at_end.position.z;
  if (!hub_free_[2]) angle_[hub] = hub_at_end.angle;

  std::swap(arms_, old_arms_);
  if (!parts_.joints.empty()) {
    constraint_impulse(warm_, 1.0, 1.0 / h, true);
    turn_arms();
    for (int iteration = 0;; ++iteration) {
      largest_gap_ = close_gaps();
      if (largest_gap_ < kGapTolerance) break;
      if (iteration == kMaximumIterations || !std::isfinite(largest_gap_)) {
        throw Error(fmt::format("the wheel's joints cannot be closed: gap {:.3g} m after {} iterations",
                                largest_gap_, iteration));
      }
      solve(gaps_);
      constraint_impulse(gaps_, 1.0, 1.0 / h, true);
      for (std::size_t j = 0; j < warm_.size(); ++j) warm_[j] = warm_[j] + gaps_[j];
      correct_arms();
    }
  } else {
    turn_arms();
  }
  elastic_forces();
  kick(0.5 * h, 0.0);
  if (!hub_free_[0]) v_[hub].x = hub_at_end.velocity.x;
  if (!hub_free_[1]) v_[hub].z = hub_at_end.velocity.z;
  if (!hub_free_[2]) rate_[hub] = hub_at_end.rate;
  if (parts_.joints.empty()) return;
  factorize();
  for (std::size_t j = 0; j < parts_.joints.size(); ++j) {
    const PlanarJoint& joint = parts_.joints[j];
    gaps_[j] = (v_[joint.a] - v_[joint.b]) + rate_[joint.a] * perp(arms_[2 * j]) -
               rate_[joint.b] * perp(arms_[2 * j + 1]);
  }
  solve(gaps_);
  constraint_impulse(gaps_, 0.0, 1.0, false);
}

}  // namespace wheel_twin::wheel
