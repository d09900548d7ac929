// Normal and shear stress under a wheel and their integrals over the contact (paper, Section 2), in the
// wheel's own frame: x along the wheel plane, y to the left, z up. SI units.
//   normal stress   sigma = k_eq zeta^n, zeta the depth that carries it: R (cos theta - cos theta_1) ahead of
//   theta_m, the
//                   sinkage z on the flat patch, and the mirrored front behind (System 2)
//   shear stress    tau = (c + sigma tan phi) (1 - exp(-|j| / K)) along the shear displacement j (Janosi,
//   Hanamoto 1961) displacement    of a rim point since entry: j_x as in the paper; j_y = v sin(beta) / omega
//   (theta_1 - theta)
//                   (Ishigami et al. 2007). Both make one vector, so the Mohr-Coulomb limit holds in every
//                   direction.
//   side walls      push soil aside: Hegedus' resistance as in Ishigami et al. 2007, mobilised by j_y
//   grousers        Bekker's passive wedge (paper, F_g), one a grouser in the soil, under the overburden of
//   its root
// Fixed Gauss-Legendre nodes, the contact split at every kink; the algebraic end of sigma (zeta^n) is graded
// away by theta = end + length t^3. Pieces whose exponential is steep are halved until it is resolved.
#pragma once

#include <cmath>

#include "terramechanics/contact_geometry.h"

namespace wheel_twin::terramechanics {

/// Factor on the pressure-sinkage law at a depth (m) below the undisturbed surface.
class DepthFactor {
 public:
  virtual ~DepthFactor() = default;
  virtual double operator()(double depth) const = 0;
};

/// How the rim moves, in units of the larger of rim speed and travel speed.
struct RimMotion {
  double rolling = 1.0;   ///< R omega: 1 when driving, 1 + s when braking, 0 when locked
  double forward = 1.0;   ///< travel speed in the wheel plane
  double sideways = 0.0;  ///< travel speed out of it, positive where the soil pushes the wheel to its left
};

/// Of slip s (-1 to 1) and steering angle (rad).
inline RimMotion rim_motion(double s, double steering_angle) {
  const double travel = s >= 0.0 ? 1.0 - s : 1.0;
  return {s >= 0.0 ? 1.0 : 1.0 + s, travel * std::cos(steering_angle), travel * std::sin(steering_angle)};
}

/// What the stresses need of soil and wheel.
struct ContactLaw {
  double b = 0.0;              ///< wheel width, m
  double k_eq = 0.0, n = 1.0;  ///< sinkage law, N/m^(n+2)
  double c = 0.0, tan_phi = 0.0, K = 0.01;
  double weight_density = 0.0;          ///< N/m^3
  double grousers = 0.0;                ///< around the rim
  double grouser_height = 0.0;          ///< m
  const DepthFactor* factor = nullptr;  ///< none: 1
};

/// Forces (N) and moments about the hub (N m) of the soil on the wheel.
struct ContactLoads {
  double vertical = 0.0;               ///< z: normal and shear stress
  double thrust = 0.0;                 ///< H: x, shear stress
  double compaction_resistance = 0.0;  ///< against x, normal stress
  double grouser_thrust = 0.0;         ///< x
  double side_shear = 0.0;             ///< y
  double bulldozing = 0.0;             ///< y, on the side wall
  double torque = 0.0;                 ///< of shear stress and grousers against the rotation
  double moment_x = 0.0, moment_z = 0.0;
};

ContactLoads contact_loads(const ContactGeometry& geometry, const RimMotion& motion, const ContactLaw& law);

/// The vertical force alone, several times cheaper.
double vertical_force(const ContactGeometry& geometry, const RimMotion& motion, const ContactLaw& law);

/// The loads of an unsteered wheel without a depth factor, split by what they are proportional to: for one
/// geometry, slip, n and K they are linear in k_eq, k_eq tan(phi), c and the two strengths of a grouser.
struct LoadBasis {
  double pressure_cos = 0.0, pressure_sin = 0.0;                  ///< times k_eq
  double friction_cos = 0.0, friction_sin = 0.0, friction = 0.0;  ///< times k_eq tan(phi)
  double cohesion_cos = 0.0, cohesion_sin = 0.0, cohesion = 0.0;  ///< times c
  double wedge = 0.0, wedge_torque = 0.0;            ///< times a grouser's strength at the surface
  double overburden = 0.0, overburden_torque = 0.0;  ///< times its growth with depth

  void add(const LoadBasis& o, double weight) {
    pressure_cos += weight * o.pressure_cos, pressure_sin += weight * o.pressure_sin;
    friction_cos += weight * o.friction_cos, friction_sin += weight * o.friction_sin;
    friction += weight * o.friction;
    cohesion_cos += weight * o.cohesion_cos, cohesion_sin += weight * o.cohesion_sin;
    cohesion += weight * o.cohesion;
    wedge += weight * o.wedge, wedge_torque += weight * o.wedge_torque;
    overburden += weight * o.overburden, overburden_torque += weight * o.overburden_torque;
  }
};

/// Of `law` only n and K count.
LoadBasis load_basis(const ContactGeometry& geometry, const RimMotion& motion, const ContactLaw& law);

/// What contact_loads() returns, from the basis.
ContactLoads combined(const LoadBasis& basis, double radius, const ContactLaw& law);
double combined_vertical(const LoadBasis& basis, double radius, const ContactLaw& law);

/// Vertical force of a wheel that has not moved (paper, static sinkage): twice the front arc and the patch,
/// no shear.
double static_vertical_force(const ContactGeometry& geometry, const ContactLaw& law);

}  // namespace wheel_twin::terramechanics
