#include "nodes/replay_twin.h"

#include <utility>

namespace wheel_twin::nodes {

ReplayTwin::ReplayTwin(RigSetup setup) : setup_(std::move(setup)) {
  reset();
}

void ReplayTwin::reset() {
  replay_.reset();
  contact_ = make_contact(setup_);
  const rig::RunSettings& run = setup_.run;
  replay_ = std::make_unique<rig::Replay>(run.rig, run.conditions, run.radius, *contact_, rig::Ports{},
                                          rig::ReplayOptions{});
}

rig::RigStep ReplayTwin::predict(const rig::MeasuredMotion& motion) {
  return replay_->update(motion);
}

}  // namespace wheel_twin::nodes
