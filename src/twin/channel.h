// The channels in which twin and rig are compared, in the names of the JSON outputs.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace wheel_twin::twin {

enum class Channel { drawbar_pull, side_force, normal_load, hub_displacement, pitch_torque, motor_effort };

inline constexpr std::size_t channel_count = 6;
inline constexpr std::array<Channel, channel_count> all_channels = {
    Channel::drawbar_pull,     Channel::side_force,   Channel::normal_load,
    Channel::hub_displacement, Channel::pitch_torque, Channel::motor_effort};

inline constexpr std::size_t index_of(Channel channel) {
  return static_cast<std::size_t>(channel);
}

/// Name in files: drawbar_pull, ...
inline constexpr std::string_view name_of(Channel channel) {
  constexpr std::array<std::string_view, channel_count> names = {
      "drawbar_pull", "side_force", "normal_load", "hub_displacement", "pitch_torque", "motor_effort"};
  return names[index_of(channel)];
}

/// SI unit: N, m or N m.
inline constexpr std::string_view unit_of(Channel channel) {
  return channel == Channel::hub_displacement                                   ? "m"
         : channel == Channel::pitch_torque || channel == Channel::motor_effort ? "N m"
                                                                                : "N";
}

/// What a person reads on a plot, and the factor to its unit (hub displacement is shown in mm).
inline constexpr std::string_view title_of(Channel channel) {
  constexpr std::array<std::string_view, channel_count> titles = {
      "Drawbar pull", "Side force", "Normal load", "Hub displacement", "Pitch torque", "Motor effort"};
  return titles[index_of(channel)];
}
inline constexpr std::string_view shown_unit_of(Channel channel) {
  return channel == Channel::hub_displacement ? "mm" : unit_of(channel);
}
inline constexpr double shown_factor(Channel channel) {
  return channel == Channel::hub_displacement ? 1000.0 : 1.0;
}

}  // namespace wheel_twin::twin
