// Errors of a twin before and after an effect is added, by channel.
#pragma once

#include <map>

#include "twin/channel.h"

namespace wheel_twin::twin {

/// RMSE of a channel, measured against twin. SI.
struct ChannelError {
  double before = 0.0;
  double after = 0.0;
  double noise_floor = 0.0;  ///< what a perfect twin would still show
};
using Errors = std::map<Channel, ChannelError>;

}  // namespace wheel_twin::twin
