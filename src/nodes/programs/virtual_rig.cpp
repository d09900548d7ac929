// The node `virtual_rig` as a program of its own.
#include "nodes/programs/run_node.h"
#include "nodes/virtual_rig_bridge.h"

int main(int argc, char** argv) {
  return wheel_twin::nodes::run_node<wheel_twin::nodes::VirtualRigBridge>(argc, argv, "virtual_rig");
}
