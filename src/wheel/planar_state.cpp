// What a PlanarSystem knows about itself: energies, momentum, natural frequency, its state as numbers.
#include <algorithm>
#include <cmath>

#include "wheel/planar_system.h"

namespace wheel_twin::wheel {

PlanarForce PlanarSystem::take_hub_impulse() {
  const PlanarForce impulse = hub_impulse_;
  hub_impulse_ = {};
  return impulse;
}

double PlanarSystem::joint_angle(int joint) const {
  const PlanarJoint& j = parts_.joints[joint];
  return angle_[j.b] - angle_[j.a] - rest_angle_[joint];
}

double PlanarSystem::spring_stretch(int spring) const {
  const PlanarSpring& s = parts_.springs[spring];
  const Vec2 d = x_[s.body] + arm(s.body, s.at_body) - x_[bodies_];
  return dot(d - arm(bodies_, rest_point_[spring]), arm(bodies_, s.direction));
}

double PlanarSystem::kinetic_energy() const {
  double energy = 0.0;
  for (int i = 0; i <= bodies_; ++i) {
    if (i < bodies_ || hub_free_[0]) energy += 0.5 * mass_[i] * v_[i].x * v_[i].x;
    if (i < bodies_ || hub_free_[1]) energy += 0.5 * mass_[i] * v_[i].z * v_[i].z;
    if (i < bodies_ || hub_free_[2]) energy += 0.5 * inertia_[i] * rate_[i] * rate_[i];
  }
  return energy;
}

double PlanarSystem::elastic_energy() const {
  double energy = 0.0;
  for (std::size_t j = 0; j < parts_.joints.size(); ++j) {
    const double angle = joint_angle(static_cast<int>(j));
    energy += 0.5 * parts_.joints[j].stiffness * angle * angle;
  }
  for (std::size_t k = 0; k < parts_.springs.size(); ++k) {
    const PlanarSpring& spring = parts_.springs[k];
    const Vec2 d = x_[spring.body] + arm(spring.body, spring.at_body) - x_[bodies_];
    const Vec2 u = d - arm(bodies_, rest_point_[k]);
    const Vec2 radial = arm(bodies_, spring.direction);
    const double u_r = dot(u, radial);
    const double u_t = dot(u, perp(radial));
    const double turn = angle_[spring.body] - angle_[bodies_] - parts_.bodies[spring.body].angle;
    energy +=
        0.5 * (spring.radial * u_r * u_r + spring.tangential * u_t * u_t + spring.turning * turn * turn);
  }
  return energy;
}

double PlanarSystem::angular_momentum() const {
  double sum = 0.0;
  for (int i = 0; i <= bodies_; ++i) {
    sum += mass_[i] * dot(perp(x_[i]), v_[i]) + inertia_[i] * rate_[i];
  }
  return sum;
}

double PlanarSystem::relative_speed() const {
  const PlanarPose reference = rigid_reference();
  double largest = 0.0;
  for (int i = 0; i <= bodies_; ++i) {
    const Vec2 v = v_[i] - reference.velocity - reference.rate * perp(x_[i] - x_[bodies_]);
    largest = std::max(largest, std::hypot(v.x, v.z));
  }
  return largest;
}

double PlanarSystem::highest_frequency() {
  if (bodies_ == 0) return 0.0;
  const std::array<bool, 3> free = hub_free_;
  set_hub_free({false, false, false});
  std::vector<PlanarPose> u(bodies_);
  std::uint32_t noise = 1;
  for (int i = 0; i < bodies_; ++i) {
    noise = noise * 1664525U + 1013904223U;  // a start vector that no mode is orthogonal to
    u[i].angle = static_cast<double>(noise) / 4294967296.0 - 0.5;
    u[i].position = {0.001 * u[i].angle, -0.001 * u[i].angle};
  }
  double eigenvalue = 0.0;
  for (int iteration = 0; iteration < 400; ++iteration) {
    std::vector<PlanarPose> a(bodies_);
    const auto angle = [&](int i) { return i == bodies_ ? 0.0 : u[i].angle; };
    for (const PlanarJoint& joint : parts_.joints) {
      const double torque = joint.stiffness * (angle(joint.b) - angle(joint.a));
      a[joint.a].angle -= torque;
      if (joint.b != bodies_) a[joint.b].angle += torque;
    }
    for (const PlanarSpring& spring : parts_.springs) {
      const Vec2 r = arm(spring.body, spring.at_body);
      const Vec2 d = u[spring.body].position + u[spring.body].angle * perp(r);
      const Vec2 radial = arm(bodies_, spring.direction);
      const Vec2 tangential = perp(radial);
      const Vec2 f =
          spring.radial * dot(d, radial) * radial + spring.tangential * dot(d, tangential) * tangential;
      a[spring.body].position = a[spring.body].position + f;
      a[spring.body].angle += dot(perp(r), f) + spring.turning * u[spring.body].angle;
    }
    for (int i = 0; i < bodies_; ++i) {
      a[i].position = inverse_mass_[i] * a[i].position;
      a[i].angle *= inverse_inertia_[i];
    }
    for (std::size_t j = 0; j < gaps_.size(); ++j) {
      const PlanarJoint& joint = parts_.joints[j];
      gaps_[j] = a[joint.a].position + a[joint.a].angle * perp(arms_[2 * j]);
      if (joint.b != bodies_) {
        gaps_[j] = gaps_[j] - a[joint.b].position - a[joint.b].angle * perp(arms_[2 * j + 1]);
      }
    }
    if (!gaps_.empty()) solve(gaps_);
    for (std::size_t j = 0; j < gaps_.size(); ++j) {
      const PlanarJoint& joint = parts_.joints[j];
      a[joint.a].position = a[joint.a].position - inverse_mass_[joint.a] * gaps_[j];
      a[joint.a].angle -= inverse_inertia_[joint.a] * dot(perp(arms_[2 * j]), gaps_[j]);
      if (joint.b == bodies_) continue;
      a[joint.b].position = a[joint.b].position + inverse_mass_[joint.b] * gaps_[j];
      a[joint.b].angle += inverse_inertia_[joint.b] * dot(perp(arms_[2 * j + 1]), gaps_[j]);
    }
    double norm = 0.0;
    double product = 0.0;
    for (int i = 0; i < bodies_; ++i) {
      norm += mass_[i] * dot(u[i].position, u[i].position) + inertia_[i] * u[i].angle * u[i].angle;
      product += mass_[i] * dot(a[i].position, a[i].position) + inertia_[i] * a[i].angle * a[i].angle;
    }
    eigenvalue = std::sqrt(product / norm);
    if (!(product > 0.0)) break;
    for (int i = 0; i < bodies_; ++i) {
      u[i].position = (1.0 / std::sqrt(product)) * a[i].position;
      u[i].angle = a[i].angle / std::sqrt(product);
    }
  }
  set_hub_free(free);
  return std::sqrt(eigenvalue);
}

namespace {
void put(std::vector<double>& out, const std::vector<Vec2>& values) {
  for (const Vec2& value : values) {
    out.push_back(value.x);
    out.push_back(value.z);
  }
}
const double* get(const double* in, std::vector<Vec2>& values) {
  for (Vec2& value : values) {
    value = {in[0], in[1]};
    in += 2;
  }
  return in;
}
}  // namespace

std::size_t PlanarSystem::state_size() const {
  return 11 * (bodies_ + 1) + 2 * warm_.size() + 7;
}

void PlanarSystem::save(std::vector<double>& out) const {
  put(out, x_);
  put(out, v_);
  out.insert(out.end(), angle_.begin(), angle_.end());
  out.insert(out.end(), rate_.begin(), rate_.end());
  out.insert(out.end(), cosine_.begin(), cosine_.end());
  out.insert(out.end(), sine_.begin(), sine_.end());
  put(out, warm_);
  for (const PlanarForce& force : previous_external_) {
    out.insert(out.end(), {force.force.x, force.force.z, force.torque});
  }
  out.push_back(previous_half_step_);
  for (const bool free : hub_free_) out.push_back(free ? 1.0 : 0.0);
  out.push_back(gravity_);
  out.push_back(relaxation_);
  out.push_back(dissipated_);
}

const double* PlanarSystem::restore(const double* in) {
  in = get(in, x_);
  in = get(in, v_);
  for (double& angle : angle_) angle = *in++;
  for (double& rate : rate_) rate = *in++;
  for (double& cosine : cosine_) cosine = *in++;
  for (double& sine : sine_) sine = *in++;
  in = get(in, warm_);
  for (PlanarForce& force : previous_external_) {
    force = {{in[0], in[1]}, in[2]};
    in += 3;
  }
  previous_half_step_ = *in++;
  for (bool& free : hub_free_) free = *in++ != 0.0;
  gravity_ = *in++;
  relaxation_ = *in++;
  dissipated_ = *in++;
  clear_external();
  hub_impulse_ = {};
  turned_ = angle_;
  place_arms();
  factorize();
  elastic_forces();
  return in;
}

}  // namespace wheel_twin::wheel
