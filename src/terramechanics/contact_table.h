// Loads of an unsteered wheel, interpolated: what a diagnosis needs that simulates the same wheel on the same
// soil a thousand times. Tabulated is the basis of the loads (stress_integrals.h), so that stiffness,
// friction angle, cohesion and grousers may change while n, K, c1, c2, gamma and the radius may not. Nodes
// lie evenly in sqrt(sinkage), sqrt(deflection) and slip, are computed when first asked for, and are
// interpolated by cubics (four nodes a direction). Safe to share between threads; the numbers do not depend
// on who asks first.
#pragma once

#include <memory>

#include "terramechanics/soil.h"
#include "terramechanics/stress_integrals.h"
#include "terramechanics/wheel.h"

namespace wheel_twin::terramechanics {

/// Where the largest normal stress is: theta_m / theta_1, 0 to 1.
double peak_position(const Soil& soil, double slip);

class ContactTable {
 public:
  ContactTable(const Wheel& wheel, const Soil& soil);
  ~ContactTable();
  ContactTable(const ContactTable&) = delete;
  ContactTable& operator=(const ContactTable&) = delete;

  /// Same radius, rigid or not, and the same n, K, c1, c2, gamma.
  bool fits(const Wheel& wheel, const Soil& soil) const;
  /// Sinkage and deflection in m. Not covered: beneath micrometres, near the hub, slips beyond +-0.92.
  bool covers(double z, double delta_d, double slip) const;

  /// As vertical_force(), contact_loads() and static_vertical_force(); z, delta_d and slip are covered.
  double vertical(double z, double delta_d, double slip, const ContactLaw& law) const;
  ContactLoads loads(double z, double delta_d, double slip, const ContactLaw& law) const;
  double at_rest(double z, double delta_d, const ContactLaw& law) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::terramechanics
