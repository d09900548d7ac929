// Each fault of a log, made in a sound run, is found; the sound run has none.
#include "logs/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "logs/bag_writer.h"
#include "logs/experiment.h"
#include "logs/topics.h"
#include "support.h"

namespace wheel_twin::logs {
namespace {

using testing::HasSubstr;

/// As if recorded: arrival is the stamp.
CheckReport check(const run_log::RunLog& log, const Declared& declared = {}) {
  Recording recording;
  recording.log = log;
  recording.ft_arrival = log.ft.time;
  recording.draw_wire_arrival = log.draw_wire.time;
  recording.joints_arrival = log.joints.time;
  recording.temperature_arrival = log.temperature.time;
  return check_recording(recording, "a.bag", declared);
}

Declared declared_run() {
  Declared declared;
  declared.load = 42.1;
  declared.wheel_radius = 0.09;
  declared.slip = 1.0 - 0.014 / (0.09 * 0.28);
  declared.wheel_speed = 0.28;
  declared.ft_rate = 50.0;
  declared.draw_wire_rate = 50.0;
  return declared;
}

testing::AssertionResult finds(const CheckReport& report, Severity severity, const std::string& kind,
                               const std::string& topic) {
  for (const Finding& finding : report.findings)
    if (finding.severity == severity && finding.kind == kind && finding.topic == topic)
      return testing::AssertionSuccess();
  return testing::AssertionFailure() << "no " << kind << " of " << topic << " in\n" << to_text(report);
}

TEST(Check, SoundRunHasNoFinding) {
  for (const double rate : {50.0, 100.0, 1000.0})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      EXPECT_EQ(to_text(check(sound_run(20.0, rate, seed))).find("warning"), std::string::npos);
      const CheckReport bare = check(sound_run(20.0, rate, seed));
      EXPECT_TRUE(bare.findings.empty()) << to_text(bare);
      Declared declared = declared_run();
      declared.ft_rate = rate;
      declared.draw_wire_rate = rate;
      const CheckReport full = check(sound_run(20.0, rate, seed), declared);
      EXPECT_TRUE(full.findings.empty()) << to_text(full);
    }
}

struct Fault {
  const char* name;
  std::function<void(run_log::RunLog&)> make;
  Severity severity;
  const char* kind;
  const char* topic;
  bool needs_declaration = false;
};

template <typename T>
void scale(std::vector<T>& values, double factor) {
  for (T& value : values) value *= factor;
}

std::vector<Fault> faults() {
  using Log = run_log::RunLog;
  constexpr auto error = Severity::error;
  constexpr auto warning = Severity::warning;
  return {
      {"forces times 1000", [](Log& l) { scale(l.ft.force, 1000.0); }, error, "units", wrench_topic},
      {"forces over 1000", [](Log& l) { scale(l.ft.force, 1e-3); }, error, "units", wrench_topic, true},
      {"torques times 1000", [](Log& l) { scale(l.ft.torque, 1000.0); }, error, "units", wrench_topic},
      {"torques over 1000", [](Log& l) { scale(l.ft.torque, 1e-3); }, warning, "units", wrench_topic},
      {"effort times 1000", [](Log& l) { scale(l.joints.wheel_effort, 1000.0); }, error, "units",
       joints_topic},
      {"displacement in mm", [](Log& l) { scale(l.draw_wire.value, 1000.0); }, error, "units",
       displacement_topic},
      {"displacement in km", [](Log& l) { scale(l.draw_wire.value, 1e-3); }, warning, "units",
       displacement_topic},
      {"carriage velocity in mm/s", [](Log& l) { scale(l.joints.carriage_velocity, 1000.0); }, error, "units",
       joints_topic},
      {"carriage in mm",
       [](Log& l) {
         scale(l.joints.carriage_velocity, 1000.0);
         scale(l.joints.carriage_position, 1000.0);
       },
       error, "units", joints_topic},
      {"wheel rate in deg/s", [](Log& l) { scale(l.joints.wheel_rate, 57.3); }, error, "units", joints_topic},
      {"wheel in degrees",
       [](Log& l) {
         scale(l.joints.wheel_rate, 57.3);
         scale(l.joints.wheel_angle, 57.3);
       },
       error, "units", joints_topic, true},
      {"wheel encoder stuck", [](Log& l) { l.joints.wheel_angle.assign(l.joints.wheel_angle.size(), 1.0); },
       error, "units", joints_topic},
      {"carriage velocity negative", [](Log& l) { scale(l.joints.carriage_velocity, -1.0); }, error, "sign",
       joints_topic},
      {"load negative",
       [](Log& l) {
         for (auto& f : l.ft.force) f.z() *= -1.0;
       },
       error, "sign", wrench_topic},
      {"pull negative",
       [](Log& l) {
         for (auto& f : l.ft.force) f.x() *= -1.0;
       },
       error, "sign", wrench_topic},
      {"displacement positive up", [](Log& l) { scale(l.draw_wire.value, -1.0); }, error, "sign",
       displacement_topic},
      {"wrench stuck",
       [](Log& l) {
         for (std::size_t i = 600; i < 640; ++i) {
           l.ft.force[i] = l.ft.force[599];
           l.ft.torque[i] = l.ft.torque[599];
         }
       },
       error, "stuck", wrench_topic},
      {"Fz stuck",
       [](Log& l) {
         for (std::size_t i = 600; i < 800; ++i) l.ft.force[i].z() = l.ft.force[599].z();
       },
       error, "stuck", wrench_topic},
      {"draw wire stuck",
       [](Log& l) {
         std::fill(l.draw_wire.value.begin() + 700, l.draw_wire.value.end(), l.draw_wire.value[700]);
       },
       error, "stuck", displacement_topic},
      {"Fz saturated at the range of a calibration",
       [](Log& l) {
         for (auto& f : l.ft.force) f.z() = std::min(f.z() * 7.0, 290.0);
       },
       error, "saturated", wrench_topic},
      {"Fx cut off",
       [](Log& l) {
         for (std::size_t i = 0; i < l.ft.force.size(); ++i)
           l.ft.force[i].x() = std::min(l.ft.force[i].x() + (i % 200 > 100 && i > 300 ? 5.0 : 0.0), 17.0);
       },
       error, "saturated", wrench_topic},
      {"tare off",
       [](Log& l) {
         for (auto& f : l.ft.force) f.y() += 3.0;
       },
       warning, "tare", wrench_topic},
      {"tare drifts",
       [](Log& l) {
         for (std::size_t i = 0; i < l.ft.force.size(); ++i) l.ft.force[i].z() += 0.15 * l.ft.time[i];
       },
       warning, "drift", wrench_topic},
      {"a gap of 0.4 s",
       [](Log& l) {
         l.draw_wire.time.erase(l.draw_wire.time.begin() + 500, l.draw_wire.time.begin() + 520);
         l.draw_wire.value.erase(l.draw_wire.value.begin() + 500, l.draw_wire.value.begin() + 520);
       },
       warning, "gap", displacement_topic},
      {"a gap of 2 s",
       [](Log& l) {
         l.draw_wire.time.erase(l.draw_wire.time.begin() + 500, l.draw_wire.time.begin() + 600);
         l.draw_wire.value.erase(l.draw_wire.value.begin() + 500, l.draw_wire.value.begin() + 600);
       },
       error, "gap", displacement_topic},
      {"no joint states", [](Log& l) { l.joints = {}; }, error, "missing", joints_topic},
      {"no wrench", [](Log& l) { l.ft = {}; }, warning, "missing", wrench_topic},
      {"no displacement", [](Log& l) { l.draw_wire = {}; }, warning, "missing", displacement_topic},
      {"draw wire an hour late",
       [](Log& l) {
         for (double& t : l.draw_wire.time) t += 3600.0;
       },
       error, "overlap", ""},
      {"another load than declared", [](Log& l) { scale(l.ft.force, 0.6); }, warning, "declared",
       wrench_topic, true},
      {"another speed than declared",
       [](Log& l) {
         scale(l.joints.wheel_rate, 0.7);
         scale(l.joints.wheel_angle, 0.7);
       },
       warning, "declared", joints_topic, true},
  };
}

TEST(Check, FindsEveryFaultByKindAndTopic) {
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(fault.name);
    run_log::RunLog log = sound_run();
    fault.make(log);
    const CheckReport declared = check(log, declared_run());
    EXPECT_TRUE(finds(declared, fault.severity, fault.kind, fault.topic));
    EXPECT_EQ(declared.fit(), fault.severity == Severity::warning) << to_text(declared);
    if (!fault.needs_declaration) {
      EXPECT_TRUE(finds(check(log), fault.severity, fault.kind, fault.topic));
    }
  }
}

TEST(Check, AStampFarInTheFutureCostsNoTime) {
  run_log::RunLog log = sound_run();
  log.joints.time.back() = 3e9;
  log.ft.time.back() = 3e9;
  const CheckReport report = check(log);
  EXPECT_TRUE(finds(report, Severity::error, "gap", wrench_topic));
}

TEST(Check, ClockOfOneTopicBehindTheOthersIsAWarning) {
  Recording recording;
  recording.log = sound_run();
  recording.ft_arrival = recording.log.ft.time;
  recording.draw_wire_arrival = recording.log.draw_wire.time;
  recording.joints_arrival = recording.log.joints.time;
  recording.temperature_arrival = recording.log.temperature.time;
  for (double& t : recording.ft_arrival) t += 1.5;
  CheckReport report = check_recording(recording, "a.bag");
  EXPECT_TRUE(finds(report, Severity::warning, "clock", wrench_topic));
  EXPECT_TRUE(report.fit());
  recording.ft_arrival[100] += 30.0;
  EXPECT_TRUE(finds(check_recording(recording, "a.bag"), Severity::warning, "stray_stamp", wrench_topic));
}

TEST(Check, LineOfAFindingHasTopicCountAndFirstTime) {
  run_log::RunLog log = sound_run();
  log.ft.force[300].z() = std::numeric_limits<double>::quiet_NaN();
  log.ft.force[400].z() = std::numeric_limits<double>::quiet_NaN();
  const CheckReport report = check(log);
  EXPECT_THAT(to_text(report), HasSubstr("a.bag: fit for use\n"));
  EXPECT_THAT(to_text(report), HasSubstr("warning: /ft_sensor/wrench: samples with NaN or infinity: dropped "
                                         "on reading (2 times, first at 6.000 s)\n"));
  const auto json = nlohmann::json::parse(to_json({report, report}));
  EXPECT_TRUE(json.at("fit"));
  EXPECT_EQ(json.at("logs").size(), 2u);
  EXPECT_EQ(json.at("logs")[0].at("findings")[0].at("count"), 2);
  EXPECT_EQ(json.at("logs")[0].at("findings")[0].at("first_time"), 6.0);
  EXPECT_EQ(json.at("logs")[0].at("topics")[0].at("messages"), 1000);
}

TEST(Check, ExperimentIsCheckedAgainstItsDeclarations) {
  const Scratch scratch;
  write_bag(sound_run(), scratch / "good.bag");
  run_log::RunLog no_force = sound_run();
  no_force.ft = {};
  write_bag(no_force, scratch / "averaged.bag");
  put_bytes(scratch / "broken.bag", "no bag");
  run_log::RunLog pressing = sound_run();
  pressing.joints = {};
  write_bag(pressing, scratch / "plate.bag");
  Experiment experiment;
  experiment.name = "e";
  logs::Run run;
  run.load = 42.1;
  run.slip = 0.444;
  run.wheel_speed = 0.28;
  run.bag = "good.bag";
  experiment.runs.push_back(run);
  run.bag = "averaged.bag";
  run.averages.emplace();
  run.averages->window_end = 1.0;
  run.averages->drawbar_pull = Average{1.0, std::nullopt};
  experiment.runs.push_back(run);
  run.bag = "broken.bag";
  experiment.runs.push_back(run);
  PlateTest plate;
  plate.bag = "plate.bag";
  plate.indenter = "plate";
  plate.diameter = 0.06;
  experiment.plate_tests.push_back(plate);
  write_experiment(experiment, scratch.path());
  const std::vector<CheckReport> reports = check_experiment(scratch.path());
  ASSERT_EQ(reports.size(), 4u);
  EXPECT_TRUE(reports[0].findings.empty()) << to_text(reports[0]);
  EXPECT_TRUE(reports[1].findings.empty()) << to_text(reports[1]);
  EXPECT_TRUE(finds(reports[2], Severity::error, "unreadable", ""));
  EXPECT_TRUE(reports[3].findings.empty()) << to_text(reports[3]);
}

}  // namespace
}  // namespace wheel_twin::logs
