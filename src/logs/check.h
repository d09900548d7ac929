// Says whether a rig log is fit for use. An error is a finding with which results would be wrong or missing;
// a warning is something that the tools cope with and a person should know. Every rule and its threshold:
// doc/importing_logs.md.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "logs/bag_reader.h"

namespace wheel_twin::logs {

enum class Severity { warning, error };

struct Finding {
  Severity severity = Severity::warning;
  std::string kind;         ///< one word for programs: damage, gap, sign, ...
  std::string topic;        ///< empty: the whole bag
  std::size_t count = 0;    ///< samples or places concerned
  double first_time = 0.0;  ///< s since the epoch of the log; NaN where there is none
  std::string text;         ///< what is wrong, with numbers and units
};

struct TopicSummary {
  std::string topic;
  std::size_t messages = 0;
  double rate = 0.0;   ///< Hz, from the median interval; NaN below 2 messages
  double start = 0.0;  ///< s since the epoch
  double end = 0.0;    ///< s
};

struct CheckReport {
  std::string file;
  double epoch = 0.0;  ///< ROS time, s
  std::vector<TopicSummary> topics;
  std::vector<Finding> findings;  ///< errors first
  bool fit() const;               ///< no error
};

/// What the operator declared of the run; makes more checks possible.
struct Declared {
  bool pressing = false;             ///< a plate or wheel pressed straight down: no joint states are needed
  bool has_wrench_averages = false;  ///< averages stand in for the wrench topic
  bool has_displacement_averages = false;  ///< averages stand in for the displacement topic
  std::optional<double> load;              ///< N
  std::optional<double> slip;
  std::optional<double> wheel_speed;     ///< rad/s
  std::optional<double> wheel_radius;    ///< m
  std::optional<double> ft_rate;         ///< Hz
  std::optional<double> draw_wire_rate;  ///< Hz
};

CheckReport check_recording(const Recording& recording, const std::string& file,
                            const Declared& declared = {});

/// A file that is no bag gives a report with one error.
CheckReport check_bag(const std::string& path, const Declared& declared = {});

/// Every bag of an experiment (its directory or experiment.yaml), each against what is declared of it. Throws
/// Error when experiment.yaml is not right.
std::vector<CheckReport> check_experiment(const std::string& path);

/// Lines for people: the file and its verdict, its topics, one line a finding.
std::string to_text(const CheckReport& report);
/// {"fit": bool, "logs": [{"file", "fit", "epoch", "topics": [...], "findings": [...]}]}
std::string to_json(const std::vector<CheckReport>& reports);

}  // namespace wheel_twin::logs
