// The node `flexible_wheel` as a program of its own.
#include "nodes/flexible_wheel_bridge.h"
#include "nodes/programs/run_node.h"

int main(int argc, char** argv) {
  return wheel_twin::nodes::run_node<wheel_twin::nodes::FlexibleWheelBridge>(argc, argv, "flexible_wheel");
}
