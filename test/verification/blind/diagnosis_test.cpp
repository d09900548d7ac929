// The loop from logs to a named cause, on a drawn rig: something hidden is found, nothing is not.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "base/error.h"
#include "draw.h"
#include "logs/bag_writer.h"
#include "logs/experiment.h"
#include "twin/baseline.h"
#include "twin/diagnosis.h"
#include "write.h"

namespace wheel_twin::blind {
namespace {

namespace fs = std::filesystem;

class Loop : public testing::Test {
 protected:
  Loop() : folder_(fs::temp_directory_path() / ("wheel_twin_blind_" + std::to_string(getpid()))) {}
  ~Loop() override { fs::remove_all(folder_); }

  twin::Diagnosis diagnosis_of(std::vector<twin::EffectSetting> effects, const std::string& outside = {},
                               double outside_size = 0.0) {
    Drawn drawn = draw(12);  // a rig with reference runs
    drawn.effects = std::move(effects);
    drawn.outside = outside;
    drawn.outside_size = outside_size;
    write(drawn, "hidden", folder_.string(), 12);
    twin::DiagnosisOptions options;
    options.threads = 1;
    return twin::diagnose(logs::read_experiment((folder_ / "hidden").string()), options);
  }

  fs::path folder_;
};

TEST_F(Loop, NothingIsFoundWhereNothingIsHidden) {
  EXPECT_EQ(diagnosis_of({}).verdict, "no_residual");
}

TEST_F(Loop, AMisalignedSensorIsNamedWithItsAngles) {
  const twin::Diagnosis found = diagnosis_of({{"ft_misalignment", {0.04, -0.03}}});
  ASSERT_EQ(found.verdict, "effect_found");
  ASSERT_FALSE(found.candidates.empty());
  const twin::Candidate& best = found.candidates.front().candidate;
  ASSERT_EQ(best.effects, std::vector<std::string>{"ft_misalignment"});
  EXPECT_NEAR(best.values[0][0], 0.04, 0.006);  // 15 %
  EXPECT_NEAR(best.values[0][1], -0.03, 0.0045);
  ASSERT_EQ(found.checks.size(), 1U);
  EXPECT_EQ(found.checks[0].effect, "ft_misalignment");
}

TEST_F(Loop, ACompactedSoilIsNamedWithItsShare) {
  const twin::Diagnosis found = diagnosis_of({{"multi_pass", {0.4}}});
  ASSERT_EQ(found.verdict, "effect_found");
  ASSERT_FALSE(found.candidates.empty());
  const twin::Candidate& best = found.candidates.front().candidate;
  ASSERT_EQ(best.effects, std::vector<std::string>{"multi_pass"});
  EXPECT_NEAR(best.values[0][0], 0.4, 0.06);
}

TEST_F(Loop, ALateDrawWireIsNamedWithItsDelay) {
  const twin::Diagnosis found = diagnosis_of({{"clock_skew", {-0.08}}});
  ASSERT_EQ(found.verdict, "effect_found");
  ASSERT_FALSE(found.candidates.empty());
  const twin::Candidate& best = found.candidates.front().candidate;
  ASSERT_EQ(best.effects, std::vector<std::string>{"clock_skew"});
  EXPECT_NEAR(best.values[0][0], -0.08, 0.012);
}

/// The effects that a diagnosis names, in the order of their names.
std::vector<std::string> named(const twin::Diagnosis& diagnosis) {
  if (diagnosis.verdict != "effect_found") return {diagnosis.verdict};
  std::vector<std::string> names = diagnosis.candidates.front().candidate.effects;
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(Loop, ASecondEffectThatMovesNoMeanIsNamedBesideTheFirst) {
  const twin::Diagnosis found = diagnosis_of({{"soil_cohesion", {900.0}}, {"slide_friction", {5.0}}});
  EXPECT_EQ(named(found), (std::vector<std::string>{"slide_friction", "soil_cohesion"})) << found.evidence;
}

TEST_F(Loop, ASmallEffectBesideALargeOneIsNamedWhereOneAloneExplainsNothing) {
  const twin::Diagnosis found =
      diagnosis_of({{"ft_drift", {-0.02, -0.03, 0.025}}, {"density_gradient", {-0.25}}});
  EXPECT_EQ(named(found), (std::vector<std::string>{"density_gradient", "ft_drift"})) << found.evidence;
  const double p = found.candidates.front().p_value;
  EXPECT_LE(found.candidates.front().probability, 1.0 / (1.0 - std::exp(1.0) * p * std::log(p)));
}

// A second effect shakes a channel that the first leaves alone: it is no noise of that channel.
TEST_F(Loop, AnEccentricWheelIsNamedBesideASensorThatReadsTooMuch) {
  const twin::Diagnosis found =
      diagnosis_of({{"ft_gain", {0.0, 0.0, -0.08}}, {"wheel_eccentricity", {0.0012, 0.8}}});
  EXPECT_EQ(named(found).back(), "wheel_eccentricity") << found.evidence;
  EXPECT_EQ(named(found).size(), 2u) << found.evidence;
}

// Each alone puts the pull of runs held out further off than it was.
TEST_F(Loop, TwoEffectsAreNamedOfWhichEachAloneForetellsWorseThanNone) {
  EXPECT_EQ(named(diagnosis_of({{"carriage_speed_error", {-0.045}}, {"ft_crosstalk", {2.5}}})),
            (std::vector<std::string>{"carriage_speed_error", "ft_crosstalk"}));
}

// A creeping wire follows the clock, a tilted bed the distance.
TEST_F(Loop, ACreepingWireIsToldFromATiltedBed) {
  EXPECT_EQ(named(diagnosis_of({{"draw_wire_drift", {6e-5}}})), std::vector<std::string>{"draw_wire_drift"});
  EXPECT_EQ(named(diagnosis_of({{"bed_tilt", {0.003}}})), std::vector<std::string>{"bed_tilt"});
}

// The travel of the belt tells it, not the clock: runs of different slip hum at different frequencies.
TEST_F(Loop, ABeltIsToldByItsPeriod) {
  const twin::Diagnosis found = diagnosis_of({}, "belt_period", 2.0);
  EXPECT_EQ(found.verdict, "unexplained");
  EXPECT_NE(found.evidence.find("mm of travel"), std::string::npos) << found.evidence;
}

TEST_F(Loop, AHumIsToldWithItsFrequency) {
  const twin::Diagnosis found = diagnosis_of({}, "hum", 0.6);
  EXPECT_EQ(found.verdict, "unexplained");
  ASSERT_FALSE(found.omnibus.findings.empty());
  ASSERT_TRUE(found.omnibus.findings.front().tone);
  EXPECT_NEAR(found.omnibus.findings.front().tone->frequency, 5.3, 0.05);
  EXPECT_NE(found.evidence.find("tone of 5.3"), std::string::npos) << found.evidence;
}

// Without reference runs the baseline bends after what is hidden: here to a soil that carries the bins it was
// fitted to and lets the wheel sink to its axle between them.
TEST_F(Loop, TheFittedSoilCarriesTheWheelInEveryBin) {
  write(draw(102), "hidden", folder_.string(), 102);
  const logs::Experiment experiment = logs::read_experiment((folder_ / "hidden").string());
  twin::GridOptions options;
  options.most_bins = 130.0;
  const std::vector<twin::RunGrid> grids = twin::read_runs(experiment, options);
  std::vector<const twin::RunGrid*> runs;
  for (const twin::RunGrid& grid : grids) runs.push_back(&grid);
  const twin::Calibration calibration = twin::calibrate(twin::declared_twin(experiment), runs,
                                                        twin::noise_floor(experiment, grids.front().bin));
  for (const twin::RunGrid* run : runs) EXPECT_NO_THROW(twin::simulate(calibration.model, *run)) << run->name;
}

// Near the slip at which its soil gives way a twin sinks to its axle as soon as it is fitted to other runs.
TEST_F(Loop, ASoilAboutToGiveWayIsDiagnosed) {
  write(draw(513), "hidden", folder_.string(), 513);
  twin::DiagnosisOptions options;
  options.threads = 1;
  EXPECT_EQ(twin::diagnose(logs::read_experiment((folder_ / "hidden").string()), options).verdict,
            "no_residual");
}

// On one load a compliant rig is an offset of the wire, but for what it reads as the wheel first touches.
TEST_F(Loop, AnOffsetOfTheWireIsToldFromACompliantRig) {
  const twin::Diagnosis found = diagnosis_of({{"draw_wire_offset", {0.002}}});
  EXPECT_EQ(named(found), std::vector<std::string>{"draw_wire_offset"}) << found.evidence;
  EXPECT_GT(found.candidates.front().probability, 0.7);  // the two alike: a half at most
}

// Of what a soil of another form leaves, one half of the runs foretells the other: not the runs held out.
TEST_F(Loop, WhatPutsRunsHeldOutFurtherOffIsNoEffect) {
  write(draw(604), "hidden", folder_.string(), 604);
  twin::DiagnosisOptions options;
  options.threads = 1;
  const twin::Diagnosis found = twin::diagnose(logs::read_experiment((folder_ / "hidden").string()), options);
  EXPECT_EQ(found.verdict, "no_residual") << found.evidence;
}

/// Experiments that no one can explain, made of the logs of a drawn rig.
class BadInput : public Loop {
 protected:
  /// Diagnoses runs at `slips` after `change` was done to what is logged and declared.
  twin::Diagnosis diagnosis_of(const std::vector<double>& slips,
                               const std::function<void(logs::Run&, run_log::RunLog&)>& change) {
    Drawn drawn = draw(12);
    drawn.effects = {{"bed_tilt", {0.03}}};
    drawn.outside.clear();
    logs::Experiment experiment;
    experiment.name = "bad";
    experiment.wheel = drawn.wheel;
    experiment.soil = drawn.declared;
    experiment.directory = folder_.string();
    fs::create_directories(folder_);
    for (const double slip : slips) {
      logs::Run run;
      run.bag = "run_" + std::to_string(experiment.runs.size()) + ".bag";
      run.slip = slip;
      run.load = drawn.run.conditions.load;
      run.wheel_speed = drawn.run.conditions.wheel_speed;
      run_log::RunLog log = simulate_run(drawn, slip, true, 12 + experiment.runs.size(), false);
      change(run, log);
      logs::write_bag(log, experiment.path_of(*run.bag));
      experiment.runs.push_back(run);
    }
    twin::DiagnosisOptions options;
    options.threads = 1;
    return twin::diagnose(experiment, options);
  }

  std::string error_of(const std::vector<double>& slips,
                       const std::function<void(logs::Run&, run_log::RunLog&)>& change) {
    try {
      return "no error: " + diagnosis_of(slips, change).verdict;
    } catch (const Error& error) {
      return error.what();
    }
  }
};

TEST_F(BadInput, OneRunNamesNoEffect) {
  const twin::Diagnosis d = diagnosis_of({0.3}, [](logs::Run&, run_log::RunLog&) {});
  EXPECT_NE(d.verdict, "effect_found");
  if (d.verdict == "unexplained") {
    EXPECT_NE(d.evidence.find("With one measured run no effect can be put to the test"), std::string::npos);
  }
}

TEST_F(BadInput, RunsWithoutASteadyPartAreRefused) {
  const std::string error = error_of({0.2, 0.4}, [](logs::Run&, run_log::RunLog& log) {
    for (std::size_t i = 0; i < log.joints.time.size(); ++i) {  // speeds up and down once a second
      const double factor = 0.5 + 0.5 * std::sin(6.0 * log.joints.time[i]);
      log.joints.carriage_velocity[i] *= factor;
      log.joints.wheel_rate[i] *= factor;
    }
  });
  EXPECT_NE(error.find("no measured run to diagnose"), std::string::npos) << error;
  EXPECT_NE(error.find("no steady part"), std::string::npos) << error;
}

TEST_F(BadInput, ContradictingDeclarationsAreRefused) {
  const std::string error =
      error_of({0.0, 0.2, 0.6}, [](logs::Run& run, run_log::RunLog&) { run.slip = 0.6 - run.slip; });
  EXPECT_NE(error.find("2 of 3 runs are no logs of what is declared"), std::string::npos) << error;
}

TEST_F(BadInput, AllChannelsSaturatedAreRefused) {
  const std::string error = error_of({0.2, 0.4}, [](logs::Run&, run_log::RunLog& log) {
    for (auto& force : log.ft.force) force.setConstant(1.0);
    for (auto& torque : log.ft.torque) torque.setConstant(0.1);
    for (double& d : log.draw_wire.value) d = 0.002;
    for (double& e : log.joints.wheel_effort) e = 0.5;
  });
  EXPECT_NE(error.find("every channel stands still while the wheel moves"), std::string::npos) << error;
}

TEST_F(BadInput, ALogOfAnotherRigIsRefused) {
  Drawn other = draw(12);
  other.run.conditions.load *= 3.0;
  const std::string error = error_of({0.2, 0.4}, [&](logs::Run& run, run_log::RunLog& log) {
    log = simulate_run(other, run.slip, false, 3, false);
  });
  EXPECT_NE(error.find("2 of 2 runs are no logs of what is declared"), std::string::npos) << error;
}

}  // namespace
}  // namespace wheel_twin::blind
