// Reads the bag of a rig (own linear scan, so that a damaged bag gives all that is intact) into memory, by
// header stamp. Topics of a rig log whose type or md5 is another than this project's are refused by name,
// never reinterpreted.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "logs/byte_source.h"
#include "run_log/run_log.h"

namespace wheel_twin::logs {

/// Something wrong with a bag that did not keep the rest from being read.
struct Defect {
  enum class Kind {
    damage,      ///< bytes of the file that are not readable records
    refused,     ///< a topic of a rig log with another type or md5
    malformed,   ///< a message that does not have the layout of its type
    time_zero,   ///< a message whose header stamp is ROS time 0: it has no time and is not in the log
    incomplete,  ///< a message without a joint or value that a rig log has
    no_checksum  ///< uncompressed chunks: a damaged value in them cannot be seen
  };
  Kind kind = Kind::damage;
  std::string topic;        ///< empty: the file
  std::size_t count = 0;    ///< messages or places concerned
  double first_time = 0.0;  ///< s since epoch, bag time of the first; NaN where unknown
  std::string text;         ///< one line
};

/// A bag as it was recorded: every sample in recorded order, with its NaN, repeated and backward stamps.
struct Recording {
  run_log::RunLog log;  ///< epoch: the earliest credible header stamp
  /// Bag (arrival) times, s since epoch, one for each sample of the series of the same name.
  std::vector<double> ft_arrival, draw_wire_arrival, joints_arrival, temperature_arrival;
  std::map<std::string, std::size_t> other_topics;  ///< messages of topics that are no part of a rig log
  std::vector<Defect> defects;
};

/// Throws Error naming the file only when nothing of it can be read as a bag of format 2.0.
Recording read_recording(const std::string& path);
Recording read_recording(ByteSource& source, const std::string& name);  ///< `name` is the file in errors

/// Fit for computing: each series sorted by stamp, stamps strictly increasing, samples that are not finite
/// dropped. A column of `joints` that the bag lacks throughout is empty. Throws Error as read_recording, and
/// for a refused topic.
run_log::RunLog read_run_log(const std::string& path);

/// The second half of read_run_log: sorts, drops repeated stamps (the first stays) and samples that are not
/// finite.
run_log::RunLog cleaned(run_log::RunLog log);

}  // namespace wheel_twin::logs
