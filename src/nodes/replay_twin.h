// The real-time twin that a Follower leads: the rig's replay mode on the semi-empirical soil, with the
// effects and corrections of a twin file when there is one. A reset begins another run on untouched soil.
#pragma once

#include <memory>

#include "nodes/follower.h"
#include "nodes/rig_setup.h"
#include "rig/replay.h"
#include "twin/simulate.h"

namespace wheel_twin::nodes {

class ReplayTwin : public FollowedTwin {
 public:
  explicit ReplayTwin(RigSetup setup);

  rig::RigStep predict(const rig::MeasuredMotion& motion) override;
  void reset() override;

 private:
  RigSetup setup_;
  twin::Acting acting_;
  std::unique_ptr<rig::Contact> contact_;
  std::unique_ptr<rig::Replay> replay_;
};

}  // namespace wheel_twin::nodes
