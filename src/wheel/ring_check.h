// A wheel's rim alone under two opposite loads: the multibody ring beside the closed form (calibration.h) and
// the elastica, which holds at any deflection. Shows what a torsion stiffness does to the ring. SI units.
#pragma once

#include "wheel/calibration.h"
#include "wheel/wheel_model.h"

namespace wheel_twin::wheel {

/// The rim alone, undamped.
WheelModel free_ring(const WheelModel& wheel);

/// Changes of both diameters of a thin inextensible ring under two opposite loads, any deflection: the
/// elastica EI psi'' = -(W/2) sin(psi) over a quarter, psi the tangent's angle from the loads' direction, by
/// shooting.
DiameterChange elastica(double radius, double flexural_rigidity, double load);
/// The load (N) that changes the loaded diameter by `fraction` of itself.
double elastica_load(double radius, double flexural_rigidity, double fraction);

/// The multibody ring's static answer: loads on the middle of two opposite segments.
DiameterChange squeeze(const WheelModel& ring, double load);

}  // namespace wheel_twin::wheel
