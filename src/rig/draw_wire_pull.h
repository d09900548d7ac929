// The wire of a draw-wire sensor pulls on the slide it measures: a spring's tension up, and a difference
// between drawing out and letting in that acts as Coulomb friction.
#pragma once

#include "rig/ports.h"
#include "rig/sensor_settings.h"

namespace wheel_twin::rig {

class DrawWirePull : public RigPort {
 public:
  explicit DrawWirePull(const DrawWireSettings& wire)
      : tension_(wire.tension_trimmed ? 0.0 : wire.tension), friction_(0.5 * wire.tension_hysteresis) {}
  double added_dead_weight(const RigState&) const override { return -tension_; }
  double coulomb_friction(const RigState&) const override { return friction_; }

 private:
  double tension_;   // N
  double friction_;  // N
};

}  // namespace wheel_twin::rig
