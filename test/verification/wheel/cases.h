// The wheel's verification cases, shared by the tests and by the long validation: a free ring under two
// opposite loads and in vibration, a wheel that stands or rolls on a hard floor; and the references that they
// are held against.
#pragma once

#include <string>
#include <vector>

#include "wheel/calibration.h"
#include "wheel/flexible_wheel.h"
#include "wheel/ring_check.h"
#include "wheel/rolling_wheel.h"

namespace wheel_twin::wheel {

/// A wheel of config/wheels without grousers, its rim's springs by the given rule.
WheelModel configured_wheel(const std::string& name, Bending rim_bending, int segments = 64);
/// Angular frequency (rad/s) of in-plane mode n of the multibody ring, from the zero crossings of a small
/// vibration.
double measured_frequency(const WheelModel& ring, int n);

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

/// AMALIA on `segments` (a multiple of 16) segments rolling so slowly, under so light a hub (the load is a
/// force), that the hub's bounce on the wheel, 23 Hz with its own mass, is far above the beat of the
/// segments.
Rolling roll_without_bounce(int segments);

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

/// A blow on a wheel that turns freely in space, hub and all.
void strike(FlexibleWheel& wheel, double dt);
/// How far what must stay strays after strike(), relative to what it was.
struct Drift {
  double momentum = 0.0;       ///< angular
  double energy = 0.0;         ///< kinetic and elastic
  double elastic_share = 0.0;  ///< of the energy, right after the blow
};
Drift free_spin(FlexibleWheel& wheel, double dt, double seconds);

/// A reference curve of test/verification/wheel/reference: hub drop (m) at a load (N), by
/// interpolation.
double finite_element_drop(const std::string& name, double load);

/// The same model by the beam model (beam_model.py): hub height (m) over a hard floor under the wheel's load
/// of the paper. `missing`: position 8 has no springs or beams; `degrees`: the wheel's angle.
double beam_model_height(const std::string& wheel, bool missing, double degrees);
/// Mean of it over a turn (a pitch without a missing position), and amplitude of its harmonic n of a turn.
double beam_model_mean(const std::string& wheel, bool missing);
double beam_model_ripple(const std::string& wheel, int n);

/// A configured wheel whose rim and beams bend as plates, as the references do.
WheelModel plate_wheel(const std::string& name, int segments = 64);

/// Minutes-long checks run where the environment variable WHEEL_TWIN_LONG is set (scripts/validate wheel).
bool long_run();

}  // namespace wheel_twin::wheel
