// The single-wheel rig: a belt-driven carriage moves a vertical slide, from which the F/T sensor, the drive
// and the wheel hang. One class for both uses: `advance` runs it freely on speed commands, `follow` leads it
// along a measured motion. Only the vertical slide (and a towed wheel's rotation) is dynamic in both. Frame
// `rig`, SI units.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "rig/contact.h"
#include "rig/ports.h"
#include "rig/settings.h"
#include "rig/step.h"

namespace wheel_twin::rig {

/// What the controllers are asked for at the end of a step.
struct Command {
  double carriage_speed = 0.0;                  ///< m/s
  double wheel_rate = 0.0;                      ///< rad/s; ignored by a towed wheel
  std::optional<double> lowest_slide_velocity;  ///< the hoist's rope, m/s, negative down; none: unhooked
};

/// A measured motion at one instant, as logged (what acts on the rig, a speed error say, is applied on top).
struct MeasuredMotion {
  double time = 0.0;               ///< s
  double carriage_position = 0.0;  ///< m
  double carriage_velocity = 0.0;  ///< m/s
  double wheel_angle = 0.0;        ///< rad
  double wheel_rate = 0.0;         ///< rad/s
  double load = 0.0;               ///< force the soil carries at rest, N
  double steering_angle = 0.0;     ///< rad
  double temperature = 22.0;       ///< degrees C
};

/// How the slide moves in `follow`.
enum class Slide {
  dynamic,      ///< with inertia, as in a free run: steps of about 1 ms
  quasi_static  ///< in equilibrium at every instant, friction included: any step; needs a repeatable contact
};

class Rig {
 public:
  /// `radius` of the wheel, m. `contact` and what `ports` point to must outlive the rig. Throws Error when
  /// the conditions are outside the rig's limits.
  Rig(const RigSettings& settings, const RunConditions& conditions, double radius, Contact& contact,
      Ports ports);
  ~Rig();
  Rig(Rig&&) noexcept;

  /// Places the hub at rest `displacement` below first touch (negative: above), or in static equilibrium on
  /// the soil, which needs a repeatable contact.
  const RigStep& start(std::optional<double> displacement);
  /// The same at the first sample of a measured motion.
  const RigStep& start(const MeasuredMotion& motion, std::optional<double> displacement);

  /// One step of dt seconds, free.
  const RigStep& advance(const Command& command, double dt);
  /// One step to `motion.time`, led by the measured motion.
  const RigStep& follow(const MeasuredMotion& motion, Slide slide);

  const RigStep& step() const;
  double draw_wire_delay() const;  ///< s, of all sensor ports

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::rig
