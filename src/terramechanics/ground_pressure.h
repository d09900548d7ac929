// Does a wheel deform on this soil or does the soil alone give way? Critical ground pressure (paper, Eq. 1;
// Wong 1978) against the mean pressure of the flat patch on hard ground. SI units.
#pragma once

#include "terramechanics/soil.h"
#include "terramechanics/wheel.h"

namespace wheel_twin::terramechanics {

/// k_c / b_s + k_phi, N/m^(n+2); b_s, the smaller side of the contact area, is taken as the wheel's width.
/// Throws Error when it is not positive.
double sinkage_modulus(const Wheel& wheel, const Soil& soil);

/// p_gcr of Eq. 1, Pa. Needs n < 3.
double critical_ground_pressure(const Wheel& wheel, const Soil& soil, double load);

/// Load over the flat patch b l_d that the wheel's stiffness gives on hard ground, Pa; infinite for a rigid
/// wheel.
double hard_ground_pressure(const Wheel& wheel, double load);

/// The paper's rule: a wheel works as a flexible one where its hard-ground pressure is below the critical
/// one.
bool works_as_flexible(const Wheel& wheel, const Soil& soil, double load);

/// Length of the flat patch 2 sqrt(2 R delta_d - delta_d^2), m.
double flat_patch_length(double radius, double deflection);

}  // namespace wheel_twin::terramechanics
