// Wheel and soil in other nodes, behind the rig's contact interface: each call asks flexible_wheel (topics
// rig/hub_motion and wheel/hub_load) and waits for the answer of the same number. Frame `rig`, SI units.
#pragma once

#include <wheel_twin/HubLoad.h>
#include <wheel_twin/HubMotion.h>

#include <functional>
#include <string>
#include <vector>

#include "nodes/asker.h"
#include "rig/contact.h"

namespace wheel_twin::nodes {

class RemoteWheel final : public rig::Contact {
 public:
  /// `patience`: s that the wheel may be silent during a run. `quit`: the node ends. One at a time.
  RemoteWheel(const ros::NodeHandle& node, double patience, std::function<bool()> quit);
  ~RemoteWheel() override;

  struct Opening {
    std::string wheel, soil, settings;  ///< names of what takes part
    double clearance = 0.0;             ///< height of the hub at which a run can start, m
  };
  /// Begins a run, on the untouched bed or from a checkpoint (a file of the wheel's machine; empty: none).
  /// `effects` (effects/acting.h) act on wheel and soil there. The bed may have to be made first, which takes
  /// minutes.
  Opening open(const std::string& checkpoint, const std::vector<std::string>& effects);

  /// All throw Error naming the side and the step when wheel or soil fail, are gone or stall, NodeEnds when
  /// the node ends.
  rig::HubLoad advance(const rig::HubMotion& motion) override;
  void write_checkpoint(const std::string& path);
  bool replaying() const { return replaying_; }
  void hold();  ///< no request for a while
  /// The run is over; `why`: what cut it short, or empty.
  void close(const std::string& why);

 private:
  Asker<HubMotion, HubLoad> wheel_;
  double patience_;
  bool replaying_ = false;
};

}  // namespace wheel_twin::nodes
