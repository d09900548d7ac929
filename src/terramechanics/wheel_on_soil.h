// Semi-empirical model of a flexible wheel on soft soil (paper, Section 2), extended to braking, locked,
// towed and steered wheels. Forces are those of the soil on the wheel in rig axes: x along travel, y to the
// left, z up. SI units. Slip s = 1 - v / (R omega) when driving, R omega / v - 1 when braking, with v the
// travel speed: -1 (locked) to 1 (no advance). theta_m = (c1 + c2 |s|) theta_1, held within 0 and theta_1:
// the peak moves ahead in skid as it does in slip.
#pragma once

#include <memory>

#include "terramechanics/contact_table.h"
#include "terramechanics/soil.h"
#include "terramechanics/stress_integrals.h"
#include "terramechanics/wheel.h"

namespace wheel_twin::terramechanics {

/// How the wheel is used.
struct Operation {
  double slip = 0.0;            ///< -1 to 1
  double steering_angle = 0.0;  ///< rad, wheel turned to the left when positive; |angle| at most 1.5
};

/// What may change the soil's answer at a place or time.
struct SoilChange {
  double added_cohesion = 0.0;  ///< Pa
  /// Loose soil, positive: the wheel sinks this many times as deep as in the law's, and all stresses are less
  /// by what the deeper contact needs less of them to carry the same load.
  double sinkage_factor = 1.0;
  double stiffness_factor = 1.0;              ///< on the pressure of the sinkage law, positive
  const DepthFactor* depth_factor = nullptr;  ///< a further one that varies with depth; none: 1
};

/// Wheel and soil in equilibrium, or at a given hub displacement.
struct ContactState {
  double sinkage = 0.0;           ///< m, sinkage_factor included
  double deflection = 0.0;        ///< m
  double hub_displacement = 0.0;  ///< sinkage + deflection, m
  double entry_angle = 0.0;       ///< theta_1, rad
  double exit_angle = 0.0;        ///< theta_2, rad, negative
  double deflection_angle = 0.0;  ///< theta_d, rad
  double peak_angle = 0.0;        ///< theta_m, rad

  double normal_load = 0.0;   ///< +z, N
  double drawbar_pull = 0.0;  ///< +x, N, all contributions
  double side_force = 0.0;    ///< +y, N
  double drive_torque = 0.0;  ///< what the drive supplies about the wheel's axle, N m, positive driving
  double torque_x = 0.0;      ///< of the soil about the hub, rig axes, N m
  double torque_y = 0.0;
  double torque_z = 0.0;

  // Parts, in the wheel plane, N:
  double thrust = 0.0;  ///< H, without grousers
  double grouser_thrust = 0.0;
  double compaction_resistance = 0.0;  ///< RF_AB + RF_CD
  double flexing_resistance = 0.0;     ///< R_f
  double bulldozing_force = 0.0;       ///< out of the plane, on the side wall
  double grousers_in_soil = 0.0;       ///< mean number over a turn
};

class WheelOnSoil {
 public:
  /// Throws Error when the two make no model (no stiffness left in the soil, n outside 0 to 3, no radius).
  /// With a table for this wheel and soil the loads are interpolated in it where it covers them.
  WheelOnSoil(const Wheel& wheel, const Soil& soil, std::shared_ptr<const ContactTable> table = nullptr);

  /// Equilibrium under a load (N, at least 0). The deflection is load / stiffness. Of several sinkages that
  /// carry the load the smallest is the equilibrium: the one a wheel lowered from the surface reaches. Throws
  /// Error when no sinkage up to the hub carries the load, saying how much is carried at most and where.
  /// `sinkage_guess` (m, 0: none) saves time.
  ContactState at_load(double load, const Operation& operation, const SoilChange& change = {},
                       double sinkage_guess = 0.0) const;

  /// The same for a wheel that is pressed straight down and has not moved (paper, static sinkage): forces but
  /// the normal load are zero. Throws Error likewise.
  ContactState at_rest_under_load(double load, const SoilChange& change = {}) const;

  /// Loads when the hub is `hub_displacement` (m) below its height at first touch; nothing acts at or above
  /// it. The deflection is the one at which soil and wheel carry the same load; `deflection_guess` (m,
  /// negative: none) saves time. Throws Error when the hub is below the surface.
  ContactState at_hub_displacement(double hub_displacement, const Operation& operation,
                                   const SoilChange& change = {}, double deflection_guess = -1.0) const;
  ContactState at_rest_at_hub_displacement(double hub_displacement, const SoilChange& change = {},
                                           double deflection_guess = -1.0) const;

  /// d(normal load) / d(hub displacement) at a state of at_hub_displacement (N/m); may be negative beyond the
  /// peak.
  double vertical_stiffness(const ContactState& state, const Operation& operation,
                            const SoilChange& change = {}) const;
  double vertical_stiffness_at_rest(const ContactState& state, const SoilChange& change = {}) const;

  /// Slip of a wheel under a load with zero drive torque. Throws Error when there is none between locked and
  /// s = 1.
  double towed_slip(double load, double steering_angle = 0.0, const SoilChange& change = {}) const;

  const Wheel& wheel() const { return wheel_; }
  const Soil& soil() const { return soil_; }

 private:
  struct Vertical;
  ContactLaw law(const SoilChange& change) const;
  double deflection_under(double load) const;
  double guess_sinkage(double load, double delta_d) const;
  ContactState solve_load(double load, const Vertical& vertical, double sinkage_guess) const;
  ContactState solve_displacement(double hub_displacement, const Vertical& vertical,
                                  double deflection_guess) const;
  double share_displacement(double hub_displacement, const Vertical& vertical, double deflection_guess) const;
  void fill_loads(ContactState& state, const Vertical& vertical) const;
  double stiffness(const ContactState& state, const Vertical& vertical) const;
  Vertical rolling(const Operation& operation, const SoilChange& change) const;
  Vertical resting(const SoilChange& change) const;

  Wheel wheel_;
  Soil soil_;
  double k_eq_;
  std::shared_ptr<const ContactTable> table_;
};

/// The steady state of one run: what a rig measures in the mean. Builds the model and calls at_load.
ContactState predict_steady_state(const Wheel& wheel, const Soil& soil, double load,
                                  const Operation& operation, const SoilChange& change = {});

}  // namespace wheel_twin::terramechanics
