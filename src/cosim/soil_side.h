// What a co-simulated wheel knows of the soil: it says where its rim segments are at the end of a step and
// gets back what the soil exerts on each of them. One call is one step of the soil; in one process a plain
// call, between processes a pair of messages with the same step number. Frame `rig`, SI units.
#pragma once

#include <cstdint>
#include <vector>

#include "wheel/flexible_wheel.h"

namespace wheel_twin::cosim {

class SoilSide {
 public:
  virtual ~SoilSide() = default;
  virtual double time_step() const = 0;  ///< s
  /// Moves every segment to `segments` (their motion at the end of the step) and the soil by one step.
  /// Returns force and torque (about the segment's reference point) of the soil on every segment, valid until
  /// the next call. `step` counts from 1. Throws Error when the physics breaks or the other side is gone.
  virtual const std::vector<wheel::Wrench>& advance(std::int64_t step,
                                                    const std::vector<wheel::SegmentState>& segments) = 0;
};

}  // namespace wheel_twin::cosim
