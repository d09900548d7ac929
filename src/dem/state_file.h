// The state of a granular system in an archive and back, and checkpoints of long runs. What is read back
// continues with the same bits.
#pragma once

#include <chrono>
#include <string>

#include "dem/archive.h"
#include "dem/system.h"

namespace wheel_twin::dem {

/// Puts `state` into `archive`.
void store(const State& state, Archive& archive);

/// Throws Error naming the file when an entry is missing or its length does not fit.
State load_state(const Archive& archive);

/// What decides how a state goes on: templates, materials, settings. A checkpoint is only taken up by the
/// same.
std::string system_fingerprint(const System& system);

void write_checkpoint(const std::string& path, const System& system);
/// Refuses, naming the file, a checkpoint of a system with other templates, materials or settings.
void restore_checkpoint(const std::string& path, System& system);

/// Writes a checkpoint when `interval` seconds of wall time have passed since the last one, so that a process
/// that is killed loses at most that (and the step it was in).
class Checkpoints {
 public:
  Checkpoints(std::string path, double interval);
  void update(const System& system);  ///< cheap enough for every step

 private:
  using Clock = std::chrono::steady_clock;
  std::string path_;
  std::chrono::duration<double> interval_;
  Clock::time_point written_;
};

}  // namespace wheel_twin::dem
