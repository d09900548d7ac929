#include "nodes/clean_shutdown.h"

#include <ros/init.h>

#include <csignal>

namespace wheel_twin::nodes {
namespace {

extern "C" void ask_for_shutdown(int) {
  ros::requestShutdown();
}

}  // namespace

void shut_down_on_sigterm() {
  struct sigaction present = {};
  if (sigaction(SIGTERM, nullptr, &present) != 0 || present.sa_handler != SIG_DFL) return;
  struct sigaction wanted = {};
  wanted.sa_handler = ask_for_shutdown;
  sigemptyset(&wanted.sa_mask);
  sigaction(SIGTERM, &wanted, nullptr);
}

}  // namespace wheel_twin::nodes
