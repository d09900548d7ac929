// The semi-empirical soil (terramechanics/wheel_on_soil.h) behind the rig's contact interface, with the ports
// of soil and wheel. Quasi-static: the loads follow hub height, slip and steering angle of the instant,
// except that
//   - a wheel pressed down and not yet moved rests on its static sinkage (paper) and passes into the rolling
//   state over
//     half a contact length of travel, which is what it takes to leave the print for a rut;
//   - the soil's resistance grows and shrinks with the speed of indentation (plastic loss, after Hunt and
//   Crossley 1975),
//     which damps the slide and is nothing in steady state;
//   - at rest only the vertical force is left.
// Frame `rig`, SI units.
#pragma once

#include <memory>

#include "rig/contact.h"
#include "rig/ports.h"
#include "terramechanics/wheel_on_soil.h"

namespace wheel_twin::rig {

struct SemiEmpiricalOptions {
  double damping = 10.0;  ///< force factor 1 + damping times indentation speed, s/m, at least 0
  /// Half contact lengths of travel over which a wheel that starts leaves its print, at least 0; 0: at once.
  double start_up = 1.0;
  std::shared_ptr<const terramechanics::ContactTable> table = nullptr;  ///< as of WheelOnSoil
};

class SemiEmpiricalContact : public Contact {
 public:
  /// What `ports` point to must outlive the contact; of them soil and wheel ports act here. Throws Error when
  /// wheel and soil make no model.
  SemiEmpiricalContact(const terramechanics::Wheel& wheel, const terramechanics::Soil& soil, Ports ports = {},
                       SemiEmpiricalOptions options = {});

  /// Throws Error when the hub is below the surface, or time decreases.
  HubLoad advance(const HubMotion& motion) override;
  bool repeatable() const override { return true; }

  /// Sinkage, angles and parts of the force at the last call, contact axes (along the bed).
  const terramechanics::ContactState& state() const { return state_; }

 private:
  struct Moment;
  Moment moment(const HubMotion& motion);
  RigState rig_state(const HubMotion& motion, const Moment& moment) const;

  terramechanics::WheelOnSoil model_;
  Ports ports_;
  SemiEmpiricalOptions options_;
  terramechanics::ContactState state_;

  // History at the last time and, for repeated calls, before it.
  struct History {
    double time = 0.0, x = 0.0;
    double surface = 0.0;     // height of the bed under the hub, m
    double travel = 0.0;      // since first touch: the faster of rim and carriage, m
    double rim_travel = 0.0;  // since first touch, m
    terramechanics::Operation operation;
    double direction = 1.0;
    bool touched = false;
  };
  History before_, now_;
  bool started_ = false;

  // The stiffness is a guide for integration: kept until the state has moved by a percent.
  double stiffness(const terramechanics::ContactState& state, bool rolling,
                   const terramechanics::SoilChange& change);
  struct Stiffness {
    double value = 0.0, hub_displacement = -1.0, slip = 0.0;
    bool rolling = false;
  } stiffness_;
};

}  // namespace wheel_twin::rig
