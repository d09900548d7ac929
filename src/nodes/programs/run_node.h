// What the stand-alone programs of all nodes share.
#pragma once

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <cstdio>
#include <exception>

#include "nodes/clean_shutdown.h"

namespace wheel_twin::nodes {

/// Runs until the node is asked to end; 0, or 1 after one line on standard error when it cannot be set up.
template <typename Bridge>
int run_node(int argc, char** argv, const char* name) {
  ros::init(argc, argv, name);
  shut_down_on_sigterm();
  try {
    const ros::NodeHandle node;
    const ros::NodeHandle private_node("~");
    const Bridge bridge(node, private_node);
    ros::spin();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
  return 0;
}

}  // namespace wheel_twin::nodes
