// A free run of the virtual rig in pieces, as a live node takes it: each piece gives what the sensors logged
// in the meantime, tared by the operator's bias, and writes the same samples to the bag of the run. Without
// ROS.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "logs/bag_writer.h"
#include "rig/free_run.h"

namespace wheel_twin::nodes {

enum class Phase { lowering, dwell, ramp_up, steady, ramp_down, rest, over };
const char* to_string(Phase phase);
/// Lowering as long as there is no timeline.
Phase phase_at(const std::optional<rig::Timeline>& timeline, double time);

class LiveRun {
 public:
  /// `contact` and what `ports` point to must outlive the run; `bag` empty: none is written. Throws Error on
  /// impossible settings and when the bag cannot be created.
  LiveRun(const rig::RunSettings& settings, rig::Contact& contact, const rig::Ports& ports,
          const std::string& bag);
  ~LiveRun();

  /// Steps to `until` s from the start, or for `patience` wall seconds (at least one step), and returns the
  /// samples of these steps. Throws Error when the physics breaks or the bag cannot be written; the bag then
  /// holds what was before.
  run_log::RunLog advance(double until, double patience);

  bool done() const { return run_.done(); }
  double time() const { return run_.time(); }
  double expected_end() const { return run_.expected_end(); }  ///< s
  Phase phase() const;
  const rig::RigStep& step() const { return run_.step(); }
  std::size_t messages() const { return messages_; }  ///< written to the bag or ready to be published

  void stop();  ///< ramps down from here
  /// Tares the force/torque sensor: the mean of the last readings (0.1 s) becomes zero from the next sample
  /// on. False when nothing has been read yet.
  bool bias();
  void close();  ///< gives the bag its name; also when the run is cut short

 private:
  void tare(run_log::RunLog& log);
  void write(const run_log::RunLog& log);

  rig::FreeRun run_;
  std::unique_ptr<logs::BagWriter> bag_;
  std::deque<rig::WrenchReading> recent_;
  std::size_t recent_limit_;
  rig::WrenchReading bias_;
  std::size_t messages_ = 0;
};

}  // namespace wheel_twin::nodes
