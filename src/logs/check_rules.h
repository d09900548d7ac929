// The rules behind check.h, by what they look at. Each appends its findings.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "logs/check.h"

namespace wheel_twin::logs::rules {

/// One channel of a topic: its samples that are finite, in order of time.
struct Channel {
  std::string topic;
  std::string name;  ///< with its unit: "Fz, N"
  std::vector<double> time;
  std::vector<double> value;
};

class Findings {
 public:
  void error(const std::string& kind, const std::string& topic, std::size_t count, double first_time,
             std::string text) {
    list.push_back({Severity::error, kind, topic, count, first_time, std::move(text)});
  }
  void warning(const std::string& kind, const std::string& topic, std::size_t count, double first_time,
               std::string text) {
    list.push_back({Severity::warning, kind, topic, count, first_time, std::move(text)});
  }
  void add(bool is_error, const std::string& kind, const std::string& topic, std::size_t count,
           double first_time, std::string text) {
    list.push_back(
        {is_error ? Severity::error : Severity::warning, kind, topic, count, first_time, std::move(text)});
  }
  std::vector<Finding> list;
};

void check_presence(const Recording& recording, const Declared& declared,
                    Findings& findings);  ///< damage, topics, types
void check_stamps(const Recording& recording, const Declared& declared,
                  Findings& findings);  ///< order, gaps, rates, clocks
void check_finite(const Recording& recording, Findings& findings);
/// The rest work on a cleaned log (bag_reader.h).
void check_stuck_and_saturated(const run_log::RunLog& log, Findings& findings);
void check_joints(const run_log::RunLog& log, const Declared& declared,
                  Findings& findings);  ///< units, signs, slip
void check_units(const run_log::RunLog& log, const Declared& declared,
                 Findings& findings);  ///< forces, torques, displacement
void check_signs(const run_log::RunLog& log, const Declared& declared,
                 Findings& findings);  ///< load, displacement, pull
void check_tare(const run_log::RunLog& log, const Declared& declared, Findings& findings);

/// The part of a run in which the wheel rolls at its speed (whole log without joint states). s since epoch.
std::pair<double, double> steady_part(const run_log::RunLog& log);

/// Median of `value` over the stamps in [part.first, part.second]; NaN without any.
double median_in(const std::vector<double>& time, const std::vector<double>& value,
                 std::pair<double, double> part);

std::vector<double> force_axis(const run_log::RunLog& log, int axis);  ///< 0 to 2
std::vector<double> torque_axis(const run_log::RunLog& log, int axis);

}  // namespace wheel_twin::logs::rules
