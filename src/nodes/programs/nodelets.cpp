// The nodes as nodelets of one manager.
#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <exception>
#include <memory>

#include "nodes/clean_shutdown.h"
#include "nodes/dem_soil_bridge.h"
#include "nodes/flexible_wheel_bridge.h"
#include "nodes/live_twin_bridge.h"
#include "nodes/virtual_rig_bridge.h"

namespace wheel_twin::nodes {

template <typename Bridge>
class BridgeNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    shut_down_on_sigterm();
    try {
      bridge_ = std::make_unique<Bridge>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL("%s", error.what());
      throw;
    }
  }

  std::unique_ptr<Bridge> bridge_;
};

using VirtualRigNodelet = BridgeNodelet<VirtualRigBridge>;
using LiveTwinNodelet = BridgeNodelet<LiveTwinBridge>;
using DemSoilNodelet = BridgeNodelet<DemSoilBridge>;
using FlexibleWheelNodelet = BridgeNodelet<FlexibleWheelBridge>;

}  // namespace wheel_twin::nodes

PLUGINLIB_EXPORT_CLASS(wheel_twin::nodes::VirtualRigNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(wheel_twin::nodes::LiveTwinNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(wheel_twin::nodes::DemSoilNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(wheel_twin::nodes::FlexibleWheelNodelet, nodelet::Nodelet)
