// Rigid bodies in a plane, joined by revolute joints with torsion spring-dampers, with spring-dampers to a
// hub that is prescribed or free. Time integration: RATTLE (Andersen, 1983), the symplectic, second-order,
// momentum-conserving form of velocity Verlet for systems with constraints; the joints stay closed to
// rounding. Plane axes x and z, angles about +y (z towards x). SI units.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "wheel/joint_solver.h"

namespace wheel_twin::wheel {

struct PlanarBody {
  double mass = 0.0;
  double inertia = 0.0;  ///< about the centre of mass
  Vec2 position;         ///< of the centre of mass, hub axes, undeformed
  double angle = 0.0;    ///< undeformed
};

/// Joints are listed in the order of elimination: legs from the hub to the rim, then around the rim.
struct PlanarJoint {
  int a = 0, b = 0;        ///< b may be the hub (index = number of bodies)
  Vec2 at_a, at_b;         ///< place in each body's axes from its centre of mass
  double stiffness = 0.0;  ///< N m/rad; free of torque in the undeformed state
};

/// Two springs from a point of the hub's frame to a point of a body, along fixed directions of the hub's
/// frame.
struct PlanarSpring {
  int body = 0;
  Vec2 at_body;             ///< in the body's axes from its centre of mass
  Vec2 direction;           ///< unit vector, hub axes: radial
  double radial = 0.0;      ///< N/m
  double tangential = 0.0;  ///< N/m
  double turning = 0.0;     ///< N m/rad against the body's turning relative to the hub
};

struct PlanarPose {
  Vec2 position;
  double angle = 0.0;
  Vec2 velocity;
  double rate = 0.0;
};

struct PlanarForce {
  Vec2 force;
  double torque = 0.0;
};

class PlanarSystem {
 public:
  struct Parts {
    std::vector<PlanarBody> bodies;
    std::vector<PlanarJoint> joints;
    std::vector<PlanarSpring> springs;
    double hub_mass = 1.0;
    double hub_inertia = 1.0;
    double damping_time = 0.0;  ///< dampers are this times the springs, s
  };
  explicit PlanarSystem(Parts parts);

  int bodies() const { return bodies_; }
  int hub() const { return bodies_; }
  void place(const PlanarPose& hub);
  void set_hub_free(std::array<bool, 3> free);  ///< x, z, angle
  void set_gravity(double gravity) { gravity_ = gravity; }
  double gravity() const { return gravity_; }
  void set_relaxation(double rate) { relaxation_ = rate; }
  void shift(Vec2 distance, Vec2 velocity);  ///< of everything
  /// External force of the coming step on a body or the hub, at its centre of mass.
  PlanarForce& external(int body) { return external_[body]; }
  void clear_external();
  void step(double h, const PlanarPose& hub_at_end);  ///< throws Error when the joints cannot be closed

  PlanarPose pose(int body) const { return {x_[body], angle_[body], v_[body], rate_[body]}; }
  Vec2 arm(int body, Vec2 local) const;  ///< a body's vector in plane axes
  /// Impulse of bodies on the hub about its centre since the last call, N s and N m s.
  PlanarForce take_hub_impulse();
  double joint_angle(int joint) const;  ///< change from the undeformed state, rad
  double spring_stretch(int spring) const;
  double kinetic_energy() const;
  double elastic_energy() const;
  double dissipated() const { return dissipated_; }
  double angular_momentum() const;
  double relative_speed() const;
  double largest_gap() const { return largest_gap_; }  ///< of a joint after the last step, m
  /// Highest natural frequency of the undeformed system on a fixed hub, rad/s.
  double highest_frequency();
  double damping_time() const { return parts_.damping_time; }

  void save(std::vector<double>& out) const;
  const double* restore(const double* in);
  std::size_t state_size() const;

 private:
  void turn_arms();     ///< arms from the angles
  void correct_arms();  ///< the same after small turns, cheaper
  void place_arms();
  double close_gaps();
  void elastic_forces();
  double damping_forces();  ///< returns the power they take, W
  void kick(double half_step, double correction);
  void factorize();
  void solve(std::vector<Vec2>& s);
  void constraint_impulse(const std::vector<Vec2>& s, double position_factor, double velocity_factor,
                          bool moves);
  PlanarPose rigid_reference() const;

  Parts parts_;
  int bodies_;
  JointSolver solver_;
  std::array<bool, 3> hub_free_{false, false, false};
  double gravity_ = 0.0;
  double relaxation_ = 0.0;
  std::vector<double> mass_, inertia_, inverse_mass_, inverse_inertia_;  // hub last
  std::vector<Vec2> x_, v_;
  std::vector<double> angle_, rate_, cosine_, sine_, turned_;
  std::vector<PlanarForce> elastic_, damping_, external_, previous_external_;
  double previous_half_step_ = 0.0;  // 0: no step since place()
  std::vector<double> rest_angle_;
  std::vector<Vec2> rest_point_;  // of springs, hub axes
  std::vector<Vec2> arms_, old_arms_, gaps_, warm_;
  std::vector<std::vector<Vec2>> border_;  // A^-1 U, one column a free direction of a hub with joints
  std::vector<int> border_direction_;
  std::vector<double> border_matrix_;
  PlanarForce hub_impulse_;
  double dissipated_ = 0.0;
  double largest_gap_ = 0.0;
};

}  // namespace wheel_twin::wheel
