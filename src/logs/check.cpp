#include "logs/check.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/error.h"
#include "logs/check_rules.h"
#include "logs/experiment.h"
#include "logs/statistics.h"
#include "logs/topics.h"

namespace wheel_twin::logs {
namespace {

void summarize(const char* topic, const std::vector<double>& time, CheckReport& report) {
  if (time.empty()) return;
  TopicSummary summary;
  summary.topic = topic;
  summary.messages = time.size();
  std::vector<double> intervals;
  for (std::size_t i = 1; i < time.size(); ++i) intervals.push_back(time[i] - time[i - 1]);
  summary.rate = 1.0 / median(std::move(intervals));
  const auto [start, end] = std::minmax_element(time.begin(), time.end());
  summary.start = *start;
  summary.end = *end;
  report.topics.push_back(summary);
}

CheckReport unreadable(const std::string& path, const Error& error) {
  CheckReport report;
  report.file = path;
  std::string text = error.what();
  if (text.rfind(path + ": ", 0) == 0) text.erase(0, path.size() + 2);
  report.findings.push_back(
      {Severity::error, "unreadable", "", 1, std::numeric_limits<double>::quiet_NaN(), std::move(text)});
  return report;
}

Declared declared_of(const Experiment& experiment, const Run& run) {
  Declared declared;
  declared.load = run.load;
  declared.slip = run.slip;
  declared.wheel_speed = run.wheel_speed;
  declared.wheel_radius = experiment.wheel.radius;
  if (experiment.ft) declared.ft_rate = experiment.ft->rate;
  if (experiment.draw_wire) declared.draw_wire_rate = experiment.draw_wire->rate;
  if (run.averages) {
    declared.has_wrench_averages = run.averages->drawbar_pull || run.averages->normal_load;
    declared.has_displacement_averages = run.averages->hub_displacement.has_value();
  }
  return declared;
}

}  // namespace

bool CheckReport::fit() const {
  return std::none_of(findings.begin(), findings.end(),
                      [](const Finding& f) { return f.severity == Severity::error; });
}

CheckReport check_recording(const Recording& recording, const std::string& file, const Declared& declared) {
  CheckReport report;
  report.file = file;
  report.epoch = recording.log.epoch;
  summarize(wrench_topic, recording.log.ft.time, report);
  summarize(displacement_topic, recording.log.draw_wire.time, report);
  summarize(joints_topic, recording.log.joints.time, report);
  summarize(temperature_topic, recording.log.temperature.time, report);
  rules::Findings findings;
  rules::check_presence(recording, declared, findings);
  rules::check_stamps(recording, declared, findings);
  rules::check_finite(recording, findings);
  const run_log::RunLog log = cleaned(recording.log);
  rules::check_stuck_and_saturated(log, findings);
  rules::check_joints(log, declared, findings);
  rules::check_units(log, declared, findings);
  rules::check_signs(log, declared, findings);
  rules::check_tare(log, declared, findings);
  report.findings = std::move(findings.list);
  std::stable_sort(report.findings.begin(), report.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  return report;
}

CheckReport check_bag(const std::string& path, const Declared& declared) {
  try {
    return check_recording(read_recording(path), path, declared);
  } catch (const Error& error) {
    return unreadable(path, error);
  }
}

std::vector<CheckReport> check_experiment(const std::string& path) {
  const Experiment experiment = read_experiment(path);
  std::vector<CheckReport> reports;
  for (const Run& run : experiment.runs)
    if (run.bag) reports.push_back(check_bag(experiment.path_of(*run.bag), declared_of(experiment, run)));
  Declared pressing;
  pressing.pressing = true;
  for (const PlateTest& test : experiment.plate_tests)
    if (test.bag) reports.push_back(check_bag(experiment.path_of(*test.bag), pressing));
  return reports;
}

}  // namespace wheel_twin::logs
