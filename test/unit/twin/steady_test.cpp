// Runs known by window means: their scatter, what counts once in a group, and effects found on groups left
// out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/random.h"
#include "effects/catalogue.h"
#include "twin/baseline.h"
#include "twin/log_survey.h"
#include "twin/steady_diagnosis.h"
#include "twin/steady_selection.h"

namespace wheel_twin::twin {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

logs::Run run_at(double slip, const std::string& group, double pull, double displacement) {
  logs::Run run;
  run.slip = slip;
  run.load = 25.0;
  run.wheel_speed = 0.16;
  run.group = group;
  run.averages.emplace();
  run.averages->window_start = 70.0;
  run.averages->window_end = 75.0;
  run.averages->drawbar_pull = logs::Average{pull, 0.5};
  run.averages->hub_displacement = logs::Average{displacement, 1e-5};
  return run;
}

logs::Experiment experiment_of(std::vector<logs::Run> runs) {
  logs::Experiment e;
  e.name = "steady";
  e.wheel.radius = 0.0625;
  e.wheel.width = 0.06;
  e.wheel.stiffness = std::nullopt;
  e.wheel.grousers = 0;
  e.wheel.grouser_height = 0.0;
  e.soil.k_c = 0.0;
  e.soil.k_phi = 3e6;
  e.soil.n = 1.27;
  e.soil.phi = 0.4;
  e.soil.K = 0.01;
  e.soil.c1 = 0.4;
  e.soil.c2 = 0.1;
  e.runs = std::move(runs);
  return e;
}

std::vector<SteadyRun> steady_runs(const logs::Experiment& e) {
  std::vector<SteadyRun> runs;
  for (std::size_t i = 0; i < e.runs.size(); ++i)
    runs.push_back(steady_run(e.runs[i], "run_" + std::to_string(i), e.wheel.radius));
  return runs;
}

// Pairs within a day differ by 0.2 N, days by 2 N: half the mean squared differences are the variances.
TEST(SteadyRuns, RepeatedRunsTellTheScatterWithinAndBetweenGroups) {
  std::vector<logs::Run> runs;
  for (int day = 0; day < 4; ++day)
    for (const double off : {-0.1, 0.1})
      runs.push_back(run_at(0.5, "day" + std::to_string(day), (day % 2 == 0 ? 1.0 : -1.0) + off, 0.02));
  const logs::Experiment e = experiment_of(runs);
  const SteadyScatter s = steady_noise(e, steady_runs(e))[index_of(Channel::drawbar_pull)];
  EXPECT_EQ(s.pairs, 28);
  // 4 pairs within a day: 0.02. 24 between: 8 of equal days with 0, 0, 0.2, -0.2 between; 16 about 2.
  const double other = (8 * 0.5 * 0.02 + 16 * (0.5 * 4.0 + 0.01)) / 24, same = 0.02;
  const double total = (24 * other + 4 * same) / 28;
  EXPECT_NEAR(s.total(), std::sqrt(total), 1e-9);
  EXPECT_NEAR(s.between * s.between, std::min(0.9 * total, other - same), 1e-9);
}

// An offset that all runs of a day share has, whitened, the length of one deviation between days.
TEST(SteadyRuns, WhatAGroupSharesCountsOnce) {
  std::vector<logs::Run> runs;
  for (int i = 0; i < 20; ++i) runs.push_back(run_at(0.5, "day", 0.0, 0.02));
  const logs::Experiment e = experiment_of(runs);
  const std::vector<SteadyRun> all = steady_runs(e);
  SteadyRuns some;
  for (const SteadyRun& run : all) some.push_back(&run);
  SteadyNoise noise;
  for (SteadyScatter& s : noise) s = {0.3, 2.0, 0.4, 0};  // 0.5 a run
  std::vector<double> out;
  whiten_means(some, Means(20, {2.0, 0.0}), noise, out);
  double sum = 0.0;
  for (const double v : out) sum += v * v;
  // 2 N of deviation 2 N, and the mean of twenty of 0.5 N: 4 / (4 + 0.25 / 20).
  EXPECT_NEAR(sum, 4.0 / (4.0 + 0.25 / 20.0), 1e-9);
  EXPECT_EQ(out.size(), 40u);
}

TEST(SteadyRuns, RefusesARunThatNoWheelCanStandIn) {
  logs::Run run = run_at(0.5, "day", 1.0, 0.02);
  run.averages->normal_load = logs::Average{-3.0, std::nullopt};
  EXPECT_THROW(steady_run(run, "run_0", 0.0625), Error);
}

class SteadySelection : public ::testing::Test {
 protected:
  /// Runs over slips -0.9 to 0.9 in four groups, as `model` makes them, with noise of 0.3 N and 0.3 mm.
  static logs::Experiment made_by(const TwinConfig& model) {
    Random random(3, 0);
    std::vector<logs::Run> runs;
    for (int i = 0; i < 16; ++i) {
      const double slip = -0.9 + 0.12 * i;
      logs::Run run = run_at(slip, "day" + std::to_string(i % 4), 0.0, 0.02);
      const std::vector<double> means = predict_means(model, steady_run(run, "", 0.0625));
      run.averages->drawbar_pull->mean = means[0] + 0.3 * random.normal();
      run.averages->hub_displacement->mean = means[1] + 3e-4 * random.normal();
      runs.push_back(run);
    }
    return experiment_of(runs);
  }

  static Selection select(const logs::Experiment& e) {
    const std::vector<SteadyRun> all = steady_runs(e);
    SteadyRuns runs;
    for (const SteadyRun& run : all) runs.push_back(&run);
    SteadyEvidence evidence;
    evidence.declared = declared_twin(e);
    evidence.unknowns = soil_unknowns(e.soil, 0.1, 0.05);
    evidence.noise = steady_noise(e, all);
    SelectionOptions options;
    options.most_effects = 2;
    Selection s = select_effects(evidence, runs, {"slip_loosening", "slip_sinkage", "ft_bias"}, options);
    s.nothing.left_out.runs.clear();  // the runs do not outlive this
    return s;
  }
};

TEST_F(SteadySelection, FindsTheEffectThatMadeTheRuns) {
  TwinConfig truth = declared_twin(experiment_of({}));
  truth.soil.phi = 0.36;
  truth.effects = {{"slip_loosening", {2.0, 1.0, 6.0}}};
  const Selection s = select(made_by(truth));
  ASSERT_THAT(s.chosen.fit.candidate.effects, ElementsAre("slip_loosening"));
  EXPECT_LT(s.p, 0.01);
  const auto& value = s.chosen.fit.candidate.values[0];
  const auto& error = s.chosen.fit.candidate.errors[0];
  EXPECT_NEAR(value[0], 2.0, 3.0 * error[0]);
  EXPECT_NEAR(value[2], 6.0, 3.0 * error[2]);
}

TEST_F(SteadySelection, AddsNothingToRunsThatTheSoilExplains) {
  TwinConfig truth = declared_twin(experiment_of({}));
  truth.soil.phi = 0.36;
  const Selection s = select(made_by(truth));
  EXPECT_THAT(s.chosen.fit.candidate.effects, ElementsAre());
}

TEST(Tellable, MeansTellNoPhaseNoFrictionAndNoMotor) {
  const logs::Experiment e = experiment_of({run_at(0.3, "a", 1.0, 0.02), run_at(-0.5, "b", -9.0, 0.02)});
  const std::vector<SteadyRun> all = steady_runs(e);
  SteadyEvidence evidence;
  evidence.declared = declared_twin(e);
  evidence.unknowns = soil_unknowns(e.soil, 0.1, 0.05);
  evidence.noise = steady_noise(e, all);
  const Tellable t = tellable_effects(evidence, {&all[0], &all[1]});
  EXPECT_THAT(t.names, Contains("slip_loosening"));
  EXPECT_THAT(t.names, Contains("ft_bias"));
  for (const char* name : {"wheel_eccentricity", "slide_friction", "motor_drag", "clock_skew", "buried_rock"})
    EXPECT_THAT(t.left_aside, Contains(HasSubstr(name)));
}

TEST(DiagnosisByMeans, AFewRunsAreRefusedWithTheirNumber) {
  const logs::Experiment e = experiment_of({run_at(0.3, "a", 1.0, 0.02), run_at(0.5, "b", 1.0, 0.02)});
  try {
    diagnose(e);
    FAIL() << "two runs were diagnosed";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("2 measured runs"));
  }
}

// A line 24 times a turn of 0.2 mm/s in the rim speed, and speeds that read 2 % low.
TEST(LogSurvey, FindsALineOfTheRimSpeedAndAScaleError) {
  constexpr double radius = 0.0625, speed = 0.01;
  MotionSurvey survey(radius);
  Random random(5, 0);
  for (int k = 0; k < 4; ++k) {
    run_log::RunLog log;
    double angle = 0.3 * k, x = 0.0;
    for (int i = 0; i < 6000; ++i) {
      const double rim = 3.0 * speed + 2e-4 * std::cos(24.0 * angle);
      log.joints.time.push_back(0.014 * i);
      log.joints.carriage_position.push_back(x);
      log.joints.carriage_velocity.push_back(speed / 1.02);
      log.joints.wheel_angle.push_back(angle);
      log.joints.wheel_rate.push_back((rim + 1e-4 * random.normal()) / radius);
      angle += 0.014 * rim / radius;
      x += 0.014 * speed;
    }
    survey.add(run_at(0.0, "day", 0.0, 0.02), log);
  }
  std::vector<SurveyItem> items;
  survey.report(items);
  const auto find = [&](const std::string& text) {
    for (const SurveyItem& item : items)
      if (item.what.find(text) != std::string::npos) return item;
    return SurveyItem{};
  };
  EXPECT_NEAR(find("carriage: position").value, 0.02, 1e-4);
  const SurveyItem line = find("rim speed has a line");
  EXPECT_THAT(line.what, HasSubstr("24 times"));
  EXPECT_NEAR(line.value, 0.2, 0.01);
}

TEST(LogSurvey, ZerosTellTareAndItsTemperature) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("wheel_twin_survey_test_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::string csv = "file,time_s,temperature_c,drawbar_pull_n,side_force_n,normal_load_n\n";
  for (int i = 0; i < 8; ++i)
    csv += "zero_" + std::to_string(i) + ".bag,0," + std::to_string(41.0 + 0.3 * i) + ",0.1,0.2," +
           std::to_string(-0.9 * 0.3 * i + (i % 2 == 0 ? 0.02 : -0.02)) + "\n";
  write_file((folder / "zeros.csv").string(), csv);
  logs::Experiment e = experiment_of({run_at(0.3, "a", 1.0, 0.02)});
  e.directory = folder.string();
  bool seen = false;
  for (const SurveyItem& item : survey_logs(e))
    if (item.what.find("zero of the normal load moves") != std::string::npos) {
      EXPECT_NEAR(item.value, -0.9, 3.0 * item.error);
      EXPECT_TRUE(item.found);
      seen = true;
    }
  EXPECT_TRUE(seen);
  write_file((folder / "zeros.csv").string(), csv + "torn,line\n");
  EXPECT_THROW(survey_logs(e), Error);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace wheel_twin::twin
