// A node that writes a bag must end by itself on SIGTERM as it does on SIGINT, alone or in any nodelet
// manager.
#pragma once

namespace wheel_twin::nodes {

/// From now on SIGTERM asks ROS to shut down; a handler that somebody else has set stays.
void shut_down_on_sigterm();

}  // namespace wheel_twin::nodes
