// The parts of a diagnosis, each against what is put into it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/random.h"
#include "steady_run.h"
#include "twin/baseline.h"
#include "twin/candidates.h"
#include "twin/certify.h"
#include "twin/errors_left.h"
#include "twin/first_touch.h"
#include "twin/fit.h"
#include "twin/fluctuation.h"
#include "twin/lag.h"
#include "twin/likeliest_effect.h"
#include "twin/noise.h"
#include "twin/recalibration.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {
namespace {

using testing::HasSubstr;

TwinConfig some_twin() {
  TwinConfig twin = declared_rig();
  twin.start_up = 0.2;
  return twin;
}

/// Fluctuation of first order about a value.
void add_noise(RunGrid& grid, const NoiseModel& noise, Random& random) {
  for (int c = 0; c < channel_rows; ++c) {
    const ChannelNoise& n = noise[static_cast<std::size_t>(c)];
    double value = n.deviation * random.normal();
    for (int i = 0; i < grid.bins(); ++i) {
      value = n.keep * value + n.deviation * std::sqrt(1.0 - n.keep * n.keep) * random.normal();
      grid.measured(c, i) += grid.moving[static_cast<std::size_t>(i)] ? value : n.rest * random.normal();
    }
  }
}

NoiseModel rig_noise() {
  const double deviation[] = {0.25, 0.04, 0.08, 2e-4, 0.04, 0.01};
  NoiseModel noise;
  for (std::size_t c = 0; c < channel_count; ++c) {
    noise[c].deviation = deviation[c];
    noise[c].keep = 0.4;
    noise[c].rest = 0.1 * deviation[c];
    noise[c].rest_offset = 0.1 * deviation[c];
  }
  return noise;
}

TEST(ErrorsLeft, AnEffectThatPutsRunsFurtherOffAdds) {
  Errors errors;
  errors[Channel::drawbar_pull] = {0.3, 0.4, 0.5};         // (0.16 - 0.09) / 0.25
  errors[Channel::hub_displacement] = {2e-3, 1e-3, 1e-3};  // (1 - 4) / 1
  EXPECT_NEAR(added(errors), 0.28 - 3.0, 1e-12);
  std::swap(errors[Channel::hub_displacement].before, errors[Channel::hub_displacement].after);
  EXPECT_NEAR(added(errors), 0.28 + 3.0, 1e-12);
}

/// A wheel let down at 10 mm/s from 2 mm above the soil on a bed of 5 N/mm, to 50 N; the wire is off by
/// `offset` (m) and the wrench's zero by `tare` (N).
run_log::RunLog let_down(double offset, double tare) {
  run_log::RunLog log;
  for (int i = 0; i < 500; ++i) {
    const double t = 0.02 * i;
    const double depth = std::min(0.01, 0.01 * t - 0.002);
    log.ft.time.push_back(t);
    log.ft.force.emplace_back(0.0, 0.0, tare + 5000.0 * std::max(0.0, depth));
    log.ft.torque.emplace_back(0.0, 0.0, 0.0);
    log.draw_wire.time.push_back(t);
    log.draw_wire.value.push_back(depth + offset);
  }
  return log;
}

TEST(FirstTouch, IsWhereTheLoadFirstShows) {
  for (const double offset : {0.0, 0.003, -0.004}) {
    const auto touch = first_touch(let_down(offset, 0.7));
    ASSERT_TRUE(touch);
    EXPECT_NEAR(touch->displacement, offset, 2.1e-4);  // a sample at 10 mm/s
    EXPECT_NEAR(touch->speed, 0.01, 1e-9);
  }
}

TEST(FirstTouch, NothingOfAWheelThatStandsOnTheSoil) {
  run_log::RunLog log = let_down(0.0, 0.0);
  for (auto* times : {&log.ft.time, &log.draw_wire.time}) times->erase(times->begin(), times->begin() + 100);
  log.ft.force.erase(log.ft.force.begin(), log.ft.force.begin() + 100);
  log.draw_wire.value.erase(log.draw_wire.value.begin(), log.draw_wire.value.begin() + 100);
  EXPECT_FALSE(first_touch(log));
}

TEST(FirstTouch, AnOffsetIsReadThereAndACompliantRigIsNot) {
  RunGrid run;
  run.motion.resize(1);
  run.touch = FirstTouch{0.003, 0.01};
  TwinConfig twin = some_twin();
  twin.effects = {{"draw_wire_offset", {0.003}}};
  EXPECT_DOUBLE_EQ(zero_of(twin, run), 0.003);
  twin.effects = {{"rig_compliance", {3e-5}}, {"draw_wire_scale", {0.1}}};
  EXPECT_DOUBLE_EQ(zero_of(twin, run), 0.0);
  twin.effects = {{"clock_skew", {0.1}}};  // late: the wire has read less
  EXPECT_DOUBLE_EQ(zero_of(twin, run), -0.001);
}

TEST(LeastSquares, FindsALineWithItsCovariance) {
  // y = a + b t at t = 0..9 with unit noise: cov = (A^T A)^-1, sum t = 45, sum t^2 = 285, determinant
  // 10*285-45^2 = 825.
  const ResidualFunction line = [](const std::vector<double>& x, std::vector<double>& out) {
    for (int t = 0; t < 10; ++t) out.push_back(x[0] + x[1] * t - (2.0 + 0.5 * t));
    return true;
  };
  const FitResult fit = least_squares({{"a", 0.0}, {"b", 0.0}}, line);
  ASSERT_TRUE(fit.usable);
  EXPECT_NEAR(fit.x[0], 2.0, 1e-5);
  EXPECT_NEAR(fit.x[1], 0.5, 1e-5);
  EXPECT_NEAR(fit.covariance(0, 0), 285.0 / 825.0, 1e-4);
  EXPECT_NEAR(fit.covariance(0, 1), -45.0 / 825.0, 1e-4);
}

TEST(LeastSquares, StaysInBoundsAndHearsThePrior) {
  const ResidualFunction pull = [](const std::vector<double>& x, std::vector<double>& out) {
    out.push_back(x[0] - 10.0);
    return true;
  };
  Unknown u{"a", 0.5};
  u.upper = 3.0;
  EXPECT_NEAR(least_squares({u}, pull).x[0], 3.0, 1e-6);
  Unknown with_prior{"a", 0.5};
  with_prior.prior_deviation = 1.0;  // equal weights of prior 0 and data 10
  EXPECT_NEAR(least_squares({with_prior}, pull).x[0], 5.0,
              2e-3);  // stops when the cost changes by 1e-5 of it
}

TEST(LeastSquares, SaysWhenTheStartCannotBeSimulated) {
  const ResidualFunction never = [](const std::vector<double>&, std::vector<double>&) { return false; };
  EXPECT_FALSE(least_squares({{"a", 0.0}}, never).usable);
}

TEST(Noise, EstimatesAnAutoregressiveProcess) {
  RunGrid grid = steady_run(0.2, 42.1, 4000);
  Random random(3);
  const NoiseModel truth = rig_noise();
  add_noise(grid, truth, random);
  const Residual residual = residual_of(grid, Predicted::Zero(channel_rows, grid.bins()));
  const NoiseModel found = estimate_noise({&grid}, {residual}, NoiseFloor{});
  for (std::size_t c = 0; c < channel_count; ++c) {
    // 4000 bins with correlation 0.4: about 1.5 % for the deviation, doubled for the robust estimate; the
    // slow level that is removed takes a few per cent of a correlated process.
    EXPECT_NEAR(found[c].deviation / truth[c].deviation, 1.0, 0.08) << c;
    EXPECT_NEAR(found[c].keep, 0.4, 0.08) << c;
  }
}

TEST(Noise, WhitenedNoiseHasUnitVarianceWithAndWithoutAnOffset) {
  Random random(5);
  for (const double offset : {0.0, 0.5}) {
    NoiseModel noise = rig_noise();
    double sum = 0.0;
    int count = 0;
    for (int run = 0; run < 200; ++run) {
      RunGrid grid = steady_run(0.2, 42.1);
      add_noise(grid, noise, random);
      for (int c = 0; c < channel_rows; ++c) {
        const double shift = offset * noise[static_cast<std::size_t>(c)].deviation * random.normal();
        for (int i = 10; i < grid.bins(); ++i) grid.measured(c, i) += shift;
      }
      NoiseModel with_offset = noise;
      for (ChannelNoise& n : with_offset) n.run_offset = offset * n.deviation, n.rest_offset = 0.0;
      std::vector<double> whitened;
      whiten(grid, residual_of(grid, Predicted::Zero(channel_rows, grid.bins())), with_offset, whitened);
      for (const double w : whitened) sum += w * w;
      count += static_cast<int>(whitened.size());
    }
    // 144000 values: standard error of the mean square 0.004.
    EXPECT_NEAR(sum / count, 1.0, 0.015) << offset;
  }
}

TEST(Noise, AStartThatDiesAwayIsEstimatedAndWhitened) {
  Random random(8);
  const NoiseModel noise = rig_noise();
  for (const double size : {0.0, 4.0}) {  // deviations of a bin
    std::vector<RunGrid> grids(400, steady_run(0.2, 42.1));
    std::vector<Residual> residuals;
    std::vector<const RunGrid*> runs;
    for (RunGrid& grid : grids) {
      grid.radius = 0.09;
      add_noise(grid, noise, random);
      const double start = size * noise[0].deviation * random.normal();
      for (int i = 10; i < grid.bins(); ++i)
        grid.measured(0, i) += start * std::exp(-0.2859 * grid.radius * grid.bin * (i - 9.5) / 0.045);
      residuals.push_back(residual_of(grid, Predicted::Zero(channel_rows, grid.bins())));
      runs.push_back(&grid);
    }
    NoiseModel with_start = noise;
    for (ChannelNoise& n : with_start) n.run_offset = n.rest_offset = 0.0;
    const Start found = starts_of(with_start, runs, residuals)[0];
    // 400 runs tell a variance to 7 %, and none to a quarter of the bin's deviation.
    EXPECT_NEAR(found.deviation / noise[0].deviation, size, size > 0.0 ? 0.3 : 0.5);
    if (size > 0.0) {
      EXPECT_DOUBLE_EQ(found.length, 0.045);
    }
    with_start[0].start = {size * noise[0].deviation, 0.045};
    double sum = 0.0;
    int count = 0;
    for (std::size_t r = 0; r < grids.size(); ++r) {
      std::vector<double> whitened;
      whiten(grids[r], residuals[r], with_start, whitened);
      for (const double w : whitened) sum += w * w;
      count += static_cast<int>(whitened.size());
    }
    EXPECT_NEAR(sum / count, 1.0, 0.015) << size;
  }
}

TEST(Fluctuation, AToneCommonToTheRunsIsTold) {
  Random random(6);
  for (const double hum : {0.0, 3.0}) {
    std::vector<RunGrid> grids(5, steady_run(0.2, 42.1));
    std::vector<Residual> residuals;
    std::vector<const RunGrid*> runs;
    const NoiseModel noise = rig_noise();
    for (RunGrid& grid : grids) {
      add_noise(grid, noise, random);
      const double phase = random.uniform(0.0, 2.0 * M_PI);
      for (int i = 0; i < grid.bins(); ++i)
        grid.measured(2, i) += hum * noise[2].deviation * std::sin(2.0 * M_PI * grid.time(i) / 7.3 + phase);
      residuals.push_back(residual_of(grid, Predicted::Zero(channel_rows, grid.bins())));
      runs.push_back(&grid);
    }
    const std::optional<double> tone = common_tone(runs, residuals);
    ASSERT_EQ(tone.has_value(), hum > 0.0);
    if (tone) {
      EXPECT_NEAR(*tone, 1.0 / 7.3, 0.01);
    }
  }
}

TEST(Fluctuation, OfAShortRunIsTold) {
  Random random(4);
  for (const int bins : {41, 130}) {
    RunGrid run = steady_run(0.2, 42.1, bins);
    run.measured = Predicted::Zero(channel_rows, bins);
    for (int i = 0; i < bins; ++i) run.measured(2, i) = 0.5 * random.normal();
    const auto stretches = log_deviation_by_stretch(run, run.measured);
    EXPECT_EQ(stretches.size(), bins == 41 ? 1U : 4U);
    EXPECT_NEAR(mean_of(stretches)[2], std::log(0.5), 0.35);
  }
}

TEST(Fluctuation, IsNotWhatDrifts) {
  Random random(4);
  RunGrid run = steady_run(0.2, 42.1, 130);
  run.measured = Predicted::Zero(channel_rows, 130);
  for (int i = 0; i < 130; ++i) run.measured(1, i) = 0.05 * random.normal() + 0.03 * run.time(i);
  EXPECT_NEAR(mean_of(log_deviation_by_stretch(run, run.measured))[1], std::log(0.05), 0.35);
}

TEST(Lag, FindsTheDelayOfTheDrawWire) {
  Random random(9);
  run_log::RunLog log;
  log.epoch = 1.7e9;
  double value = 0.0;
  const double delay = 0.13;
  for (int i = 0; i < 3000; ++i) {
    value = 0.95 * value + random.normal();
    log.ft.time.push_back(0.02 * i);
    log.ft.force.emplace_back(-value, 0.0, 42.0);
    log.ft.torque.emplace_back(0.0, 0.1 * value, 0.0);
    log.draw_wire.time.push_back(0.02 * i + delay);
    log.draw_wire.value.push_back(0.01 + 1e-4 * value);
  }
  const auto lag = draw_wire_lag(log);
  ASSERT_TRUE(lag);
  EXPECT_NEAR(lag->seconds, delay, 0.005);
  for (auto& d : log.draw_wire.value) d = 0.01 + 1e-4 * random.normal();
  EXPECT_FALSE(draw_wire_lag(log)) << "nothing in common, nothing to tell";
}

// Where the level is taken off, peaks of the other sign appear beyond a second: they must be high to be
// believed.
TEST(Lag, BelievesAFarOneOnlyWhenItIsPlain) {
  const auto lag_of = [](double noise) {
    constexpr int late = 85;  // samples
    Random random(9);
    run_log::RunLog log;
    log.epoch = 1.7e9;
    std::vector<double> values = {0.0};
    for (int i = 1; i < 3000 + late; ++i) values.push_back(0.9 * values.back() + random.normal());
    for (int i = 0; i < 3000; ++i) {
      const auto k = static_cast<std::size_t>(i);
      log.ft.time.push_back(0.02 * i);
      log.ft.force.emplace_back(0.0, 0.0, 42.0);
      log.ft.torque.emplace_back(0.0, 0.1 * values[k + late], 0.0);
      log.draw_wire.time.push_back(0.02 * i);
      log.draw_wire.value.push_back(0.01 + 1e-4 * (values[k] + noise * random.normal()));
    }
    return draw_wire_lag(log);
  };
  const auto plain = lag_of(0.5);
  ASSERT_TRUE(plain);
  EXPECT_NEAR(plain->seconds, 1.7, 0.02);
  EXPECT_FALSE(lag_of(4.0));
}

TEST(TwinFile, ComesBackAsItWasWritten) {
  TwinConfig twin = some_twin();
  twin.effects = {{"slide_friction", {3.25}}, {"soft_spoke", {0.001, 0.3, -1.5}}};
  twin.corrections = {{Channel::hub_displacement, 0.3, 30.0, {0.0, 0.2}, {42.1, 42.1}, {1e-4, -2e-4}}};
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("wheel_twin_twin_file_test_" + std::to_string(getpid()) + ".yaml"))
                               .string();
  write_twin(twin, path);
  const TwinConfig read = read_twin(path);
  EXPECT_EQ(twin_text(read), twin_text(twin));
  twin.effects = {{"buried_rock", {0.3, 0.02, 1.5, 1.0, 0.0}}};
  std::string shorter = twin_text(twin);
  shorter.erase(shorter.find("    climbing"), shorter.find("corrections") - shorter.find("    climbing"));
  write_file(path, shorter);
  EXPECT_EQ(twin_text(read_twin(path)), twin_text(twin)) << "what is not given is neutral";
  write_file(path, twin_text(twin) + "colour: red\n");
  try {
    read_twin(path);
    FAIL() << "an unknown key was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("colour"));
  }
  std::filesystem::remove(path);
}

TEST(Calibration, BringsAWrongSoilToTheReferenceRuns) {
  TwinConfig truth = some_twin();
  truth.soil.k_phi *= 2.0;
  truth.soil.phi = 0.6;
  std::vector<RunGrid> grids;
  std::vector<const RunGrid*> runs;
  Random random(2);
  for (const double slip : {0.0, 0.2, 0.4, 0.6}) {
    grids.push_back(steady_run(slip, 42.1));
    grids.back().measured = simulate(truth, grids.back());
    add_noise(grids.back(), rig_noise(), random);
  }
  for (const RunGrid& grid : grids) runs.push_back(&grid);
  const Calibration calibration =
      calibrate(some_twin(), runs, NoiseFloor{0.02, 0.02, 0.02, 2e-5, 4e-4, 2e-3});
  RunGrid unseen = steady_run(0.3, 42.1);
  const Predicted expected = simulate(truth, unseen), predicted = simulate(calibration.model, unseen);
  const int late = unseen.bins() - 5;
  // A run's mean is known to 0.25 N sqrt(2.3/110) = 0.04 N; between reference slips a few times that.
  EXPECT_NEAR(predicted(0, late), expected(0, late), 0.25);
  EXPECT_NEAR(predicted(3, late), expected(3, late), 1e-4);
}

// A pull that no soil of the law has, with the torque that it makes about the sensor: the mount stays told.
TEST(Calibration, TakesTheMountFromTheWrenchWhateverTheSoil) {
  TwinConfig truth = some_twin();
  truth.rig.mount.arm_z = 0.14;
  truth.rig.mount.drive_torque_share = -1.0;
  std::vector<RunGrid> grids;
  std::vector<const RunGrid*> runs;
  Random random(2);
  for (const double slip : {0.0, 0.2, 0.4, 0.6}) {
    grids.push_back(steady_run(slip, 42.1));
    RunGrid& grid = grids.back();
    grid.declared.role = logs::Role::reference;
    grid.measured = simulate(truth, grid);
    const double more = 3.0 * std::sin(8.0 * slip);  // N
    for (int i = 0; i < grid.bins(); ++i) {
      if (!grid.moving[static_cast<std::size_t>(i)]) continue;
      grid.measured(index_of(Channel::drawbar_pull), i) += more;
      grid.measured(index_of(Channel::pitch_torque), i) -= truth.rig.mount.arm_z * more;
    }
    add_noise(grid, rig_noise(), random);
  }
  for (const RunGrid& grid : grids) runs.push_back(&grid);
  const Calibration calibration =
      calibrate(some_twin(), runs, NoiseFloor{0.02, 0.02, 0.02, 2e-5, 4e-4, 2e-3});
  EXPECT_NEAR(calibration.model.rig.mount.arm_z, 0.14, 0.004);
  EXPECT_NEAR(calibration.model.rig.mount.drive_torque_share, -1.0, 0.05);
}

/// Evidence of five runs in which `truth` acts, and the twin without it.
struct Trial {
  std::vector<RunGrid> grids;
  Evidence evidence;

  Trial(const TwinConfig& truth, std::uint64_t seed) {
    Random random(seed);
    for (const double slip : {0.0, 0.15, 0.3, 0.45, 0.6}) {
      grids.push_back(steady_run(slip, 42.1));
      grids.back().measured = simulate(truth, grids.back());
      add_noise(grids.back(), rig_noise(), random);
    }
    evidence.baseline = some_twin();
    NoiseModel noise = rig_noise();
    for (ChannelNoise& n : noise) n.run_offset = 0.2 * n.deviation;
    evidence.noise.assign(grids.size(), noise);
    for (const RunGrid& grid : grids) {
      evidence.runs.push_back(&grid);
      evidence.log_deviation.emplace_back();
      evidence.calm.emplace_back();
      evidence.lag.emplace_back();
    }
  }
};

// The form of the soil that was fitted with nothing acting has bent after the effect, and stays bent while
// the effect is fitted on top of it.
TEST(Recalibration, GivesAnEffectTheSoilThatItsRunsHaveWithoutIt) {
  TwinConfig truth = some_twin();
  truth.soil.phi = 0.6;
  truth.soil.c1 = 0.35;
  truth.effects = {{"ft_misalignment", {0.05, 0.0}}};
  const Trial trial(truth, 4);
  const NoiseFloor floor{0.02, 0.02, 0.02, 2e-5, 4e-4, 2e-3};
  const Calibration bent = calibrate(some_twin(), trial.evidence.runs, floor);
  Evidence evidence = trial.evidence;
  evidence.baseline = bent.model;
  evidence.baseline.corrections.clear();
  evidence.nuisance = unknowns_beside_shape(bent);
  const std::vector<std::size_t> all = {0, 1, 2, 3, 4};
  const Candidate before = fit_candidate(evidence, {"ft_misalignment"}, all);
  const Candidate after = Recalibration(some_twin(), floor, evidence)(before);
  ASSERT_TRUE(before.usable);
  ASSERT_NE(after.own, nullptr);
  EXPECT_LT(after.chi_square, before.chi_square);
  EXPECT_NEAR(after.values[0][0], 0.05, 3.0 * after.errors[0][0]);
  EXPECT_LT(std::abs(after.model.soil.c1 - 0.35), std::abs(before.model.soil.c1 - 0.35));
}

TEST(LikeliestEffect, IsNamedFromOneRunAndNothingIsWithinTheBand) {
  NoiseModel band = rig_noise();
  for (ChannelNoise& n : band) n.run_offset = n.deviation;
  const auto named = [&](const std::vector<EffectSetting>& effects) {
    TwinConfig rig = some_twin();
    rig.effects = effects;
    RunGrid run = steady_run(0.3, 42.1);
    run.measured = simulate(rig, run);
    Random random(5);
    add_noise(run, rig_noise(), random);
    const auto found = likeliest_effect(some_twin(), run, band);
    return found ? found->name : "nothing";
  };
  EXPECT_EQ(named({}), "nothing");
  EXPECT_EQ(named({{"draw_wire_jump", {0.006, 30.0}}}), "draw_wire_jump");
  EXPECT_EQ(named({{"ft_drift", {0.05, 0.02, -0.05}}}), "ft_drift");
  EXPECT_EQ(named({{"density_gradient", {1.0}}}), "density_gradient");
}

TEST(NoiseByRun, KnowsWhereAChannelFluctuatesMore) {
  std::vector<RunGrid> grids;
  std::vector<Residual> residuals;
  Random random(8);
  for (const double slip : {0.0, 0.2, 0.4, 0.6}) {
    grids.push_back(steady_run(slip, 42.1, 400));
    grids.back().measured.setZero();
    NoiseModel noise = rig_noise();
    noise[0].deviation *= 1.0 + 5.0 * slip;
    add_noise(grids.back(), noise, random);
  }
  std::vector<const RunGrid*> runs;
  for (const RunGrid& grid : grids) {
    runs.push_back(&grid);
    residuals.push_back({grid.measured, {}});
  }
  const NoiseModel pooled = estimate_noise(runs, residuals, NoiseFloor{});
  const RunGrid between = steady_run(0.3, 42.1);
  const double least = rig_noise()[0].deviation;
  const auto found = noise_by_run(pooled, runs, residuals, NoiseFloor{}, {runs[0], runs[3], &between});
  EXPECT_NEAR(found[0][0].deviation, least, 0.25 * least);
  EXPECT_NEAR(found[1][0].deviation, 4.0 * least, 0.25 * 4.0 * least);
  EXPECT_NEAR(found[2][0].deviation, 2.5 * least, 0.25 * 2.5 * least);
  EXPECT_NEAR(found[1][2].deviation, rig_noise()[2].deviation, 0.15 * rig_noise()[2].deviation);
}

TEST(Certificate, IsGivenToTheEffectThatActsAndToNoneWhenNothingDoes) {
  TwinConfig tilted = some_twin();
  tilted.effects = {{"bed_tilt", {0.02}}};
  const Trial acting(tilted, 11), clean(some_twin(), 12);
  const std::vector<std::size_t> all = {0, 1, 2, 3, 4};
  const Candidate found = fit_candidate(acting.evidence, {"bed_tilt"}, all);
  ASSERT_TRUE(found.usable);
  EXPECT_NEAR(found.values[0][0], 0.02, 4.0 * found.errors[0][0]);
  EXPECT_LT(certify(acting.evidence, fit_candidate(acting.evidence, {}, all), found), 1e-3);
  EXPECT_LT(ask_residual(acting.evidence, some_twin(), false).p, 1e-6);
  EXPECT_GT(ask_residual(acting.evidence, found.model, false).p, 0.01);

  const Candidate phantom = fit_candidate(clean.evidence, {"bed_tilt"}, all);
  EXPECT_GT(certify(clean.evidence, fit_candidate(clean.evidence, {}, all), phantom), 0.01);

  // What runs differ by is known by few runs: a level must stand out more.
  TwinConfig biased = some_twin();
  biased.effects = {{"ft_bias", {0.5, 0.0, 0.0}}};
  Trial level(biased, 13);
  level.evidence.slow_freedom = 1000.0;
  const double by_many = ask_residual(level.evidence, some_twin(), false).p;
  level.evidence.slow_freedom = 4.0;
  const double by_few = ask_residual(level.evidence, some_twin(), false).p;
  EXPECT_LT(by_many, 0.01);
  EXPECT_GT(by_few, 5.0 * by_many);
  EXPECT_GT(ask_residual(clean.evidence, some_twin(), false).p, 0.01);
}

}  // namespace
}  // namespace wheel_twin::twin
