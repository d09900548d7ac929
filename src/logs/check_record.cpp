// Rules on how a log was recorded: damage, topics, order and spacing of stamps, clocks, values that are not
// finite.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "logs/check_rules.h"
#include "logs/statistics.h"
#include "logs/topics.h"

namespace wheel_twin::logs::rules {
namespace {

constexpr double no_time = std::numeric_limits<double>::quiet_NaN();
constexpr double gap_periods = 5.0;  // of the median interval; shorter ones are jitter
constexpr double long_gap = 1.0;     // s; the twin would invent the motion in between
constexpr double lost_share = 0.01;  // of samples that may be dropped before results suffer
constexpr double slow_rate = 10.0;   // Hz; below it a run is hardly followed
constexpr double rate_tolerance = 0.1;
constexpr double reorder_periods = 3.0;   // messages overtaking one another, against a clock set back
constexpr double clock_offset = 60.0;     // s between stamp and recorder's clock
constexpr double clock_difference = 0.5;  // s between the clocks of two topics
constexpr double stray_stamp = 1.0;       // s off the topic's own usual delay

struct Series {
  const char* topic;
  const std::vector<double>* stamp;
  const std::vector<double>* arrival;
};

std::array<Series, 4> series_of(const Recording& recording) {
  const run_log::RunLog& log = recording.log;
  return {{{wrench_topic, &log.ft.time, &recording.ft_arrival},
           {displacement_topic, &log.draw_wire.time, &recording.draw_wire_arrival},
           {joints_topic, &log.joints.time, &recording.joints_arrival},
           {temperature_topic, &log.temperature.time, &recording.temperature_arrival}}};
}

const char* kind_of(Defect::Kind kind) {
  switch (kind) {
    case Defect::Kind::damage:
      return "damage";
    case Defect::Kind::refused:
      return "type";
    case Defect::Kind::malformed:
      return "malformed";
    case Defect::Kind::time_zero:
      return "time_zero";
    case Defect::Kind::incomplete:
      return "incomplete";
    case Defect::Kind::no_checksum:
      break;
  }
  return "no_checksum";
}

double median_interval(std::vector<double> stamps) {
  std::sort(stamps.begin(), stamps.end());
  std::vector<double> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i)
    if (stamps[i] > stamps[i - 1]) intervals.push_back(stamps[i] - stamps[i - 1]);
  return median(std::move(intervals));
}

void check_order(const Series& series, double interval, Findings& findings) {
  const std::vector<double>& stamp = *series.stamp;
  std::size_t back = 0;
  std::size_t repeated = 0;
  double first_back = no_time;
  double first_repeated = no_time;
  double worst = 0.0;
  double latest = -std::numeric_limits<double>::infinity();
  for (const double t : stamp) {
    if (t < latest) {
      if (back++ == 0) first_back = t;
      worst = std::max(worst, latest - t);
    } else if (t == latest) {
      if (repeated++ == 0) first_repeated = t;
    }
    latest = std::max(latest, t);
  }
  if (back > 0)
    findings.add(!(worst <= reorder_periods * interval), "backward", series.topic, back, first_back,
                 fmt::format("stamps go backward by up to {:.4g} s: {}", worst,
                             worst <= reorder_periods * interval
                                 ? "messages out of order, sorted on reading"
                                 : "a clock was set back or two recordings are mixed"));
  if (repeated > 0)
    findings.add(static_cast<double>(repeated) > lost_share * static_cast<double>(stamp.size()), "repeated",
                 series.topic, repeated, first_repeated,
                 "stamps stand there twice: the later samples are dropped on reading");
}

void check_gaps(const Series& series, double interval, Findings& findings) {
  std::vector<double> stamps = *series.stamp;
  std::sort(stamps.begin(), stamps.end());
  std::size_t gaps = 0;
  double first = no_time;
  double longest = 0.0;
  double total = 0.0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double gap = stamps[i] - stamps[i - 1];
    if (gap <= gap_periods * interval) continue;
    if (gaps++ == 0) first = stamps[i - 1];
    longest = std::max(longest, gap);
    total += gap;
  }
  if (gaps == 0) return;
  const bool is_optional = series.topic == std::string(temperature_topic);
  findings.add(!is_optional && longest > long_gap, "gap", series.topic, gaps, first,
               fmt::format("gaps of up to {:.3g} s, {:.3g} s together, in a topic of {:.4g} Hz", longest,
                           total, 1.0 / interval));
}

void check_rate(const Series& series, double interval, const Declared& declared, Findings& findings) {
  const double rate = 1.0 / interval;
  const std::string topic = series.topic;
  if (topic == temperature_topic) return;
  const auto& expected = topic == wrench_topic ? declared.ft_rate : declared.draw_wire_rate;
  if (topic != joints_topic && expected && std::abs(rate / *expected - 1.0) > rate_tolerance)
    findings.warning("rate", topic, 1, series.stamp->front(),
                     fmt::format("{:.4g} Hz, declared are {:.4g} Hz", rate, *expected));
  if (rate < slow_rate)
    findings.warning("rate", topic, 1, series.stamp->front(),
                     fmt::format("{:.3g} Hz is slow for a run", rate));
}

/// Delay of the recorder's clock behind the stamps: its usual value, and the samples that are far from it.
double check_clock(const Series& series, Findings& findings) {
  std::vector<double> delays(series.stamp->size());
  for (std::size_t i = 0; i < delays.size(); ++i) delays[i] = (*series.arrival)[i] - (*series.stamp)[i];
  const double usual = median(delays);
  std::size_t stray = 0;
  std::size_t first = 0;
  double worst = 0.0;
  for (std::size_t i = 0; i < delays.size(); ++i) {
    if (std::abs(delays[i] - usual) <= stray_stamp) continue;
    if (stray++ == 0) first = i;
    worst = std::max(worst, std::abs(delays[i] - usual));
  }
  if (stray > 0)
    findings.add(static_cast<double>(stray) > lost_share * static_cast<double>(delays.size()), "stray_stamp",
                 series.topic, stray, (*series.arrival)[first],
                 fmt::format("stamps up to {:.4g} s off the time at which the message was recorded", worst));
  if (std::abs(usual) > clock_offset)
    findings.warning("clock", series.topic, delays.size(), series.stamp->front(),
                     fmt::format("stamps are {:.4g} s {} the recorder's clock", std::abs(usual),
                                 usual > 0.0 ? "behind" : "ahead of"));
  return usual;
}

}  // namespace

void check_presence(const Recording& recording, const Declared& declared, Findings& findings) {
  bool refused[3] = {false, false, false};
  for (const Defect& defect : recording.defects) {
    const bool is_wrench = defect.topic == wrench_topic;
    const bool is_displacement = defect.topic == displacement_topic;
    if (defect.kind == Defect::Kind::refused)
      refused[is_wrench ? 0 : is_displacement ? 1 : 2] = defect.topic != temperature_topic;
    const bool is_error = defect.topic != temperature_topic && defect.kind != Defect::Kind::time_zero &&
                          defect.kind != Defect::Kind::no_checksum &&
                          !(defect.kind == Defect::Kind::incomplete && defect.text.rfind("effort", 0) == 0);
    findings.add(is_error, kind_of(defect.kind), defect.topic, defect.count, defect.first_time, defect.text);
  }
  const run_log::RunLog& log = recording.log;
  const auto missing = [&](bool is_error, const char* topic, const char* consequence) {
    findings.add(is_error, "missing", topic, 1, no_time, fmt::format("topic is missing: {}", consequence));
  };
  const bool no_wrench = log.ft.time.empty();
  const bool no_displacement = log.draw_wire.time.empty();
  if (no_wrench && no_displacement && log.joints.time.empty() && recording.defects.empty()) {
    std::string topics;
    for (const auto& [topic, count] : recording.other_topics) topics += (topics.empty() ? "" : ", ") + topic;
    findings.error(
        "foreign", "", recording.other_topics.size(), no_time,
        topics.empty()
            ? "the bag holds no message"
            : fmt::format("no topic of a rig log, but {:.200}: foreign logs come in by `twin import`",
                          topics));
    return;
  }
  if (no_wrench && !refused[0] && !declared.has_wrench_averages)
    missing(no_displacement || declared.pressing, wrench_topic, "no force can be compared");
  if (no_displacement && !refused[1] && !declared.has_displacement_averages)
    missing(no_wrench || declared.pressing, displacement_topic, "no sinkage can be compared");
  if (log.joints.time.empty() && !refused[2] && !declared.pressing)
    missing(true, joints_topic, "the twin cannot be driven with the measured motion");
}

void check_stamps(const Recording& recording, const Declared& declared, Findings& findings) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  std::string least_topic;
  std::string most_topic;
  double latest_start = -std::numeric_limits<double>::infinity();
  double earliest_end = std::numeric_limits<double>::infinity();
  for (const Series& series : series_of(recording)) {
    const std::vector<double>& stamp = *series.stamp;
    const bool is_optional = series.topic == std::string(temperature_topic);
    if (stamp.empty()) continue;
    const double delay = check_clock(series, findings);
    if (!is_optional) {
      if (delay < least) least_topic = series.topic;
      if (delay > most) most_topic = series.topic;
      least = std::min(least, delay);
      most = std::max(most, delay);
      latest_start = std::max(latest_start, quantile(stamp, 0.01));
      earliest_end = std::min(earliest_end, quantile(stamp, 0.99));
    }
    const double interval = median_interval(stamp);
    if (stamp.size() < 2 || !(interval > 0.0)) {
      if (!is_optional)
        findings.error("rate", series.topic, stamp.size(), stamp.front(), "all samples have one stamp");
      continue;
    }
    check_order(series, interval, findings);
    check_gaps(series, interval, findings);
    check_rate(series, interval, declared, findings);
  }
  if (most - least > clock_difference)
    findings.warning(
        "clock", most_topic, 1, no_time,
        fmt::format("its stamps lie {:.4g} s earlier against the recorder's clock than those of {}",
                    most - least, least_topic));
  if (latest_start > earliest_end)
    findings.error("overlap", "", 1, earliest_end,
                   "the topics do not overlap in time: nothing can be compared");
}

void check_finite(const Recording& recording, Findings& findings) {
  const run_log::RunLog& log = recording.log;
  const auto check = [&](const char* topic, const std::vector<double>& time, auto is_finite) {
    std::size_t count = 0;
    double first = no_time;
    for (std::size_t i = 0; i < time.size(); ++i) {
      if (is_finite(i)) continue;
      if (count++ == 0) first = time[i];
    }
    if (count > 0)
      findings.add(static_cast<double>(count) > lost_share * static_cast<double>(time.size()), "not_finite",
                   topic, count, first, "samples with NaN or infinity: dropped on reading");
  };
  check(wrench_topic, log.ft.time,
        [&](std::size_t i) { return log.ft.force[i].allFinite() && log.ft.torque[i].allFinite(); });
  check(displacement_topic, log.draw_wire.time,
        [&](std::size_t i) { return std::isfinite(log.draw_wire.value[i]); });
  check(temperature_topic, log.temperature.time,
        [&](std::size_t i) { return std::isfinite(log.temperature.value[i]); });
  const run_log::JointSeries& joints = log.joints;
  // Missing columns are NaN throughout and reported as incomplete.
  std::vector<const std::vector<double>*> columns;
  for (const auto* column : {&joints.carriage_position, &joints.carriage_velocity, &joints.wheel_angle,
                             &joints.wheel_rate, &joints.wheel_effort})
    if (std::any_of(column->begin(), column->end(), [](double v) { return std::isfinite(v); }))
      columns.push_back(column);
  check(joints_topic, joints.time, [&](std::size_t i) {
    return std::all_of(columns.begin(), columns.end(),
                       [i](const auto* column) { return std::isfinite((*column)[i]); });
  });
}

}  // namespace wheel_twin::logs::rules
