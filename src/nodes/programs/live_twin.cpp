// The node `live_twin` as a program of its own.
#include "nodes/live_twin_bridge.h"
#include "nodes/programs/run_node.h"

int main(int argc, char** argv) {
  return wheel_twin::nodes::run_node<wheel_twin::nodes::LiveTwinBridge>(argc, argv, "live_twin");
}
