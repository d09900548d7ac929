// The co-simulation behind the rig's contact interface: a flexible wheel (or a rigid one) on a soil side that
// answers step by step. Between two calls of the rig the hub moves along a cubic through both ends; in every
// step of the soil
//   1. the wheel takes the soil's forces of the last step and moves by one step (velocity Verlet, sub-stepped
//      where it must be),
//   2. the soil takes the segments' new motion, moves by one step and gives new forces.
// The load on the hub is the rim's mean reaction since the last call. Ports of the wheel act by lifting the
// hub over the wheel's centre. Frame `rig`, SI units.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cosim/soil_side.h"
#include "rig/contact.h"
#include "rig/ports.h"
#include "wheel/flexible_wheel.h"

namespace wheel_twin::cosim {

/// Work and energy since the first call, J. kinetic + elastic + dissipated of the wheel change by hub_work +
/// soil_work; soil_work is the opposite of what the walls of the wheel do on the grains.
struct CouplingEnergy {
  double hub_work = 0.0;   ///< of the hub on the rim
  double soil_work = 0.0;  ///< of the soil on the rim
  wheel::Energy wheel;
};

/// Wall-clock seconds.
struct CouplingCost {
  std::int64_t steps = 0;
  double wheel = 0.0;
  double soil = 0.0;  ///< exchange included where the soil is another process
};

/// Everything that decides how a coupled run goes on beside the soil's own state.
struct CouplingState {
  std::int64_t step = 0;
  std::vector<double> wheel;              ///< FlexibleWheel::save
  std::vector<wheel::Wrench> soil_loads;  ///< of the last step
  std::vector<rig::HubLoad> answers;      ///< to every call so far
  rig::HubMotion motion;                  ///< of the last call
  double rim_travel = 0.0;
};

class CoupledContact final : public rig::Contact {
 public:
  /// `soil` and what `ports` point to must outlive the contact; of the ports those of the wheel act here.
  CoupledContact(const wheel::WheelModel& model, SoilSide& soil, rig::Ports ports = {});

  /// The first call places the wheel, undeformed, and must leave it clear of the soil. Throws Error when the
  /// time since the last call is no multiple of the soil's step, or the physics breaks.
  rig::HubLoad advance(const rig::HubMotion& motion) override;

  /// Height of the hub over the rig's z = 0 at zero displacement, m: the rim's outer face touches the
  /// surface.
  double radius() const { return radius_; }
  const wheel::FlexibleWheel& wheel() const { return wheel_; }
  const std::vector<wheel::SegmentState>& segments() const { return segments_; }
  const std::vector<wheel::Wrench>& soil_loads() const { return loads_; }
  CouplingEnergy energy() const;
  CouplingCost cost() const { return cost_; }

  CouplingState state() const;
  /// From now on the calls are answered from `state.answers` until they are used up, then the wheel and the
  /// soil (which the caller has restored) go on with identical bits. To be called before the first advance().
  void resume(CouplingState state);
  bool replaying() const { return replayed_ < to_replay_.size(); }

 private:
  wheel::HubMotion hub_at(const rig::HubMotion& motion) const;
  rig::RigState state_at(const rig::HubMotion& motion) const;
  rig::HubLoad replay(const rig::HubMotion& motion);
  void read_segments();

  wheel::FlexibleWheel wheel_;
  SoilSide& soil_;
  rig::Ports ports_;
  double radius_ = 0.0;
  std::vector<wheel::SegmentState> segments_;
  std::vector<wheel::Wrench> loads_;
  std::int64_t step_ = 0;
  bool placed_ = false;
  rig::HubMotion motion_;
  wheel::HubMotion hub_;
  double rim_travel_ = 0.0;
  double hub_work_ = 0.0, soil_work_ = 0.0;
  CouplingCost cost_;
  std::vector<rig::HubLoad> answers_, to_replay_;
  std::size_t replayed_ = 0;
  CouplingState resumed_;
};

}  // namespace wheel_twin::cosim
