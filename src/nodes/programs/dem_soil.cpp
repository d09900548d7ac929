// The node `dem_soil` as a program of its own.
#include "nodes/dem_soil_bridge.h"
#include "nodes/programs/run_node.h"

int main(int argc, char** argv) {
  return wheel_twin::nodes::run_node<wheel_twin::nodes::DemSoilBridge>(argc, argv, "dem_soil");
}
