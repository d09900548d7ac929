// From sheet metal to torsion springs: the paper's procedure (Section 6.2, as printed) and the stiffness of a
// bending segment. Thin-ring formulas: Young and Budynas, Roark's Formulas, table 9.2. SI units.
#pragma once

#include "wheel/wheel_model.h"

namespace wheel_twin::wheel {

/// The paper's procedure for a ring of `segments` (a multiple of 4) of the given radius (m) and flexural
/// rigidity E I (N m^2): the loaded ring is taken for an ellipse, the joints' rotations are read where the
/// ellipse's parameter is equally spaced, and their energy is set equal to Eq. 5, which is half of the load's
/// work. The stiffness (N m/rad) depends on the load (N) through the ellipse's shape; small loads give the
/// limit. Throws Error for a load that flattens the ellipse by more than 15 % of the diameter, the
/// procedure's own bound.
double printed_stiffness(int segments, double radius, double flexural_rigidity, double load);

/// A load that changes the diameter by 0.01 %: the small-load limit of printed_stiffness.
double small_load(double radius, double flexural_rigidity);

/// E I / L or, for a plate, E I / ((1 - nu^2) L), N m/rad.
double bending_stiffness(const Sheet& sheet, Bending bending, double length);

/// Change of the loaded (negative) and the free diameter of a thin inextensible ring under two opposite
/// loads, small deflection, m: -(pi/4 - 2/pi) and (2/pi - 1/2) times W R^3/(E I).
struct DiameterChange {
  double loaded = 0.0;
  double free = 0.0;
};
DiameterChange ring_under_opposite_loads(double radius, double flexural_rigidity, double load);

/// In-plane natural angular frequency of a free thin inextensible ring, n waves around it, rad/s (Hoppe,
/// 1871).
double ring_frequency(int n, double radius, double flexural_rigidity, double mass_per_length);

}  // namespace wheel_twin::wheel
