// Tones of a run: narrow lines of the spectrum of a channel, at the full rate of its sensor. Gears, belts and
// the mains make them; grains fluctuate over broad bands.
#pragma once

#include <array>
#include <vector>

#include "run_log/run_log.h"
#include "twin/channel.h"

namespace wheel_twin::twin {

struct Tone {
  double frequency = 0.0;  ///< Hz
  double amplitude = 0.0;  ///< unit of the channel
  double deviation = 0.0;  ///< of the channel about its trend, with the tone
  double p = 1.0;          ///< of a line as strong anywhere in the spectrum of noise without lines
};

/// Of each channel, the strongest first.
using Tones = std::array<std::vector<Tone>, channel_count>;

/// Tones between `begin` and `end`, times of the log in s, and above `lowest`, Hz. A line is weighed
/// against the median of the spectrum about it (exponentially distributed in noise, whatever its colour), so
/// that slow noise has none. Nothing of channels with fewer than 256 samples.
Tones tones_of(const run_log::RunLog& log, double begin, double end, double lowest);

/// What a tone may follow: the clock, the travel of the carriage or the turns of the wheel.
enum class Follows { time, travel, wheel };

/// The tones of a run and its speeds.
struct RunTones {
  const Tones* tones = nullptr;
  double carriage_speed = 0.0;  ///< m/s
  double wheel_rate = 0.0;      ///< rad/s
};

/// A tone that runs share and that no reference run has.
struct SharedTone {
  Channel channel = Channel::drawbar_pull;
  Follows follows = Follows::time;
  double frequency = 0.0;  ///< Hz, 1/m or cycles a turn
  Tone tone;               ///< of the run in which it is the median in amplitude
  int runs = 0;
};

/// Tones that most of `runs` share, that are at least `share` of the channel's deviation, and of which no
/// line stands at the same frequency in any of `references`. What all three agree on follows the clock.
std::vector<SharedTone> shared_tones(const std::vector<RunTones>& runs,
                                     const std::vector<RunTones>& references, double share);

}  // namespace wheel_twin::twin
