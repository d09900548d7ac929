// The wheel's verification cases, shared by the tests and by the long validation: a free ring under two
// opposite loads and in vibration, a wheel that stands or rolls on a hard floor; and the references that they
// are held against.
#pragma once

#include <string>
#include <vector>

#include "wheel/calibration.h"
#include "wheel/flexible_wheel.h"
#include "wheel/rigid_floor.h"

namespace wheel_twin::wheel {

/// A wheel of config/wheels without grousers, its rim's springs by the given rule.
WheelModel configured_wheel(const std::string& name, Bending rim_bending, int segments = 64);
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
/// Angular frequency (rad/s) of in-plane mode n of the multibody ring, from the zero crossings of a small
/// vibration.
double measured_frequency(const WheelModel& ring, int n);

/// Hub drop (m) of a wheel that stands on a hard floor, loaded at the hub: from first touch, less the floor's
/// overlap. `angle` is the wheel's.
double standing_deflection(const WheelModel& model, double load, double angle = 0.0);

/// One sample of a wheel rolling on a hard floor.
struct RollingSample {
  double distance = 0.0;    ///< m
  double hub_height = 0.0;  ///< m
  double thrust = 0.0;      ///< N, floor on wheel along travel
  double normal = 0.0;      ///< N
  double angle = 0.0;       ///< of the wheel, rad
};
struct Rolling {
  std::vector<RollingSample> samples;
  double dissipated = 0.0;  ///< J over the sampled distance
};
/// Free rolling: hub drawn at `speed`, spin free, hub height free under `load` (N). The first `settle` metres
/// are not kept. `friction` is the floor's; `floor_damping` N s/m a corner.
Rolling roll(const WheelModel& model, double load, double speed, double settle, double distance,
             double floor_damping = 0.0);

struct RollingMeans {
  double hub_height = 0.0;  ///< m
  double thrust = 0.0;      ///< N
  double resistance = 0.0;  ///< N: the dampers' work over the distance
  double radius = 0.0;      ///< m rolled per radian
};
RollingMeans means(const Rolling& rolling);
/// Amplitude (m) of the hub height's harmonic with `per_revolution` periods a turn.
double ripple(const Rolling& rolling, double per_revolution);
/// Hub height (m) where the wheel's angle is `angle` modulo a turn, mean within `half_window` rad.
double height_at(const Rolling& rolling, double angle, double half_window);

/// A reference curve of test/verification/wheel/calculix/reference: hub drop (m) at a load (N), by
/// interpolation.
double finite_element_drop(const std::string& name, double load);

}  // namespace wheel_twin::wheel
