#include "twin/gathering.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "twin/certify.h"
#include "twin/open_soils.h"
#include "twin/steady_runs.h"

namespace wheel_twin::twin {
namespace {

constexpr int fewest_steady_bins = 12;         // of a run
constexpr std::size_t fewest_to_hold_out = 5;  // measured runs
constexpr double lag_tolerance = 0.1;          // s, between runs of one clock
constexpr double lag_error = 0.02;             // s, of one run
constexpr double own_lag = 0.05;               // s, that wire and wrench may have without a clock being late

/// The lag that most runs agree on; a clock is late in every run, a chance correlation in one.
std::optional<double> common_lag(const std::vector<const RunGrid*>& runs) {
  std::vector<double> lags;
  for (const RunGrid* run : runs)
    if (run->lag) lags.push_back(run->lag->seconds);
  if (lags.size() < 2) return std::nullopt;
  std::sort(lags.begin(), lags.end());
  const double median = lags[lags.size() / 2];
  const auto agreeing = std::count_if(lags.begin(), lags.end(),
                                      [&](double lag) { return std::abs(lag - median) < lag_tolerance; });
  if (2 * static_cast<std::size_t>(agreeing) <= lags.size() || agreeing < 2) return std::nullopt;
  return median;
}

/// Noise of the measured runs: at least that of the reference runs, more where they fluctuate more.
NoiseModel common_noise(const NoiseModel& reference, const NoiseModel& measured) {
  NoiseModel noise = reference;
  for (std::size_t c = 0; c < channel_count; ++c) {
    noise[c].rest = std::max(noise[c].rest, measured[c].rest);
    if (measured[c].deviation > noise[c].deviation) {
      noise[c].deviation = measured[c].deviation;
      noise[c].keep = measured[c].keep;
    }
  }
  return noise;
}

}  // namespace

std::vector<const RunGrid*> RunsByRole::judged() const {
  std::vector<const RunGrid*> runs = measured;
  runs.insert(runs.end(), held_out.begin(), held_out.end());
  return runs;
}

void RunsByRole::keep_what_carries(const TwinConfig& twin) {
  std::vector<const RunGrid*> kept;
  for (const RunGrid* run : held_out) {
    try {
      simulate(twin, *run);
      kept.push_back(run);
    } catch (const Error& error) {
      warnings.push_back(
          fmt::format("{}: not held out, the twin cannot carry it ({})", run->name, error.what()));
    }
  }
  held_out = kept;
}

RunsByRole usable_runs(const std::string& experiment, const TwinConfig& declared,
                       std::vector<RunGrid>& grids) {
  RunsByRole result;
  std::vector<RunGrid*> moving[2];  // references, others
  for (RunGrid& grid : grids) {
    if (steady_bins_of(grid) < fewest_steady_bins)
      result.warnings.push_back(fmt::format("{}: no steady part ({:.3g} s at constant speeds), left out",
                                            grid.name, steady_bins_of(grid) * grid.bin));
    else
      moving[grid.declared.role == logs::Role::reference ? 0 : 1].push_back(&grid);
  }
  std::size_t all = 0, usable = 0;
  std::string reason;
  for (const auto& runs : moving) {
    for (const RecordingError& error : put_right(runs, declared)) result.recording_errors.push_back(error);
    for (const RunGrid* run : runs) {
      ++all;
      const std::string why = contradiction(*run);
      if (!why.empty()) {
        reason = run->name + ": " + why;
        result.warnings.push_back(reason + "; left out");
        continue;
      }
      ++usable;
      (run->declared.role == logs::Role::reference  ? result.references
       : run->declared.role == logs::Role::measured ? result.measured
                                                    : result.held_out)
          .push_back(run);
    }
  }
  if (2 * usable < all)
    throw Error(fmt::format("{}: {} of {} runs are no logs of what is declared ({})", experiment,
                            all - usable, all, reason));
  if (result.measured.empty())
    throw Error(fmt::format("{}: no measured run to diagnose{}", experiment,
                            result.warnings.empty() ? "" : " (" + result.warnings.front() + ")"));
  if (!result.calibrated())
    result.warnings.push_back("no reference runs: the baseline is fitted together with the effect");
  if (result.held_out.empty() && result.measured.size() >= fewest_to_hold_out) {
    std::vector<const RunGrid*> kept;
    for (std::size_t i = 0; i < result.measured.size(); ++i)
      (i % 4 == 2 ? result.held_out : kept).push_back(result.measured[i]);
    result.measured = kept;
  }
  result.clock = clock_lag(result.measured, result.references);
  const double late = result.clock.mean();
  for (RunGrid& grid : grids)
    if (grid.declared.role != logs::Role::reference) mask_about_changes(late, grid);
  return result;
}

Gathering::Gathering(const TwinConfig& declared, const RunsByRole& runs, const NoiseFloor& floor)
    : runs_(runs),
      floor_(floor),
      calibration_(calibrate(declared, runs.calibrated() ? runs.references : runs.measured, floor)) {
  TwinConfig baseline = calibration_.model;
  baseline.table = std::make_shared<terramechanics::ContactTable>(baseline.wheel, baseline.soil);
  const auto left = [&](const std::vector<const RunGrid*>& of) {
    Left result{of, {}};
    for (const RunGrid* run : of) result.residuals.push_back(residual_of(*run, simulate(baseline, *run)));
    return result;
  };
  measured_ = {left(runs.measured)};
  evidence_.runs = runs.measured;
  evidence_.baseline = baseline;
  if (runs.calibrated()) {
    references_ = left(runs.references);
    starts_ = starts_of(calibration_.noise, runs.references, references_.residuals);
    const std::vector<const RunGrid*> judged = runs.judged();
    soils_ = open_soils(declared, calibration_, runs.references);
    const auto open = left_open(soils_, runs.references, judged);
    for (std::size_t r = 0; r < judged.size(); ++r) left_open_[judged[r]] = open[r];
    evidence_.fluctuation = fit_fluctuation(baseline, runs.references, references_.residuals);
    evidence_.beyond = fluctuation_beyond(evidence_.fluctuation, baseline, runs.references,
                                          references_.residuals, runs.measured);
  } else {
    evidence_.baseline.corrections.clear();
    evidence_.nuisance = unknowns_beside_shape(calibration_);
    // Nothing tells how far the soil's form is off, which no correction of the baseline holds here.
    const NoiseFloor missed = missed_by_contact_law(runs.measured);
    for (std::size_t c = 0; c < channel_count; ++c)
      calibration_.noise[c].run_offset = std::hypot(calibration_.noise[c].run_offset, missed[c]);
  }
  evidence_.noise = noise_of(runs.measured);
  evidence_.slow_freedom =
      std::max(3.0, static_cast<double>(runs.references.size() + runs.measured.size()) - 2.0);
  set_lags();
  set_zeros();
  set_tones();
  if (runs.calibrated()) set_left_of_references();
  for (std::size_t r = 0; r < runs.measured.size(); ++r) {
    const RunGrid& run = *runs.measured[r];
    evidence_.log_deviation.push_back(log_deviation_by_stretch(run, measured_.front().residuals[r].bins));
    evidence_.calm.push_back(
        evidence_.fluctuation.known
            ? predicted_log_deviation(evidence_.baseline, run, evidence_.fluctuation_of(r))
            : LogDeviation{});
  }
}

/// How late the draw wire is: against the reference runs, whose own lag is the zero, or without any by what
/// most runs agree on.
void Gathering::set_lags() {
  if (!runs_.references.empty()) {
    evidence_.lag = runs_.clock.by_run;
    evidence_.lag_error = runs_.clock.error;
    return;
  }
  const std::optional<double> common = common_lag(evidence_.runs);
  double count = 0.0;
  for (const RunGrid* run : evidence_.runs) {
    evidence_.lag.emplace_back();
    if (!run->lag || !common || std::abs(run->lag->seconds - *common) > lag_tolerance) continue;
    evidence_.lag.back().push_back(run->lag->seconds);
    count += 1.0;
  }
  evidence_.lag_error = std::hypot(lag_error, std::sqrt(count) * own_lag);
}

/// Where the draw wire reads that the wheel touches, against the reference runs.
void Gathering::set_zeros() {
  constexpr double least_error = 3e-4;  // m: sampling, and how soon a soil carries
  constexpr std::size_t fewest = 3;     // reference runs
  if (!runs_.recording_errors.empty()) return;
  std::vector<double> of_references;
  for (const RunGrid* run : runs_.references)
    if (run->touch) of_references.push_back(run->touch->displacement);
  if (of_references.size() < fewest) return;
  const auto n = static_cast<double>(of_references.size());
  const double mean = std::accumulate(of_references.begin(), of_references.end(), 0.0) / n;
  double square = 0.0;
  for (const double zero : of_references) square += (zero - mean) * (zero - mean);
  double known = 0.0;
  for (const RunGrid* run : evidence_.runs) {
    evidence_.zero.push_back(run->touch ? run->touch->displacement - mean : std::nan(""));
    if (run->touch) known += 1.0;
  }
  // All runs share what the references' mean is off by.
  evidence_.zero_error = std::max(least_error, std::sqrt(square / (n - 1.0))) * std::sqrt(1.0 + known / n);
}

/// What hums in the measured runs and not in the reference runs; without any, what does not follow the
/// grousers either.
void Gathering::set_tones() {
  constexpr double worth_a_word = 0.3;      // of a channel's deviation
  constexpr double of_the_grousers = 0.05;  // relative
  const auto tones = [](const std::vector<const RunGrid*>& runs) {
    std::vector<RunTones> result;
    for (const RunGrid* run : runs)
      result.push_back({&run->tones, typical_carriage_speed(*run), largest_wheel_rate(*run)});
    return result;
  };
  evidence_.tones = shared_tones(tones(runs_.measured), tones(runs_.references), worth_a_word);
  if (!runs_.references.empty()) return;
  const auto of_grousers = [&](const SharedTone& shared) {
    return std::any_of(runs_.measured.begin(), runs_.measured.end(), [&](const RunGrid* run) {
      const double passing = evidence_.baseline.wheel.grousers * largest_wheel_rate(*run) / (2.0 * M_PI);
      const double harmonic = std::round(shared.tone.frequency / passing);
      return harmonic >= 1.0 &&
             std::abs(shared.tone.frequency / (harmonic * passing) - 1.0) < of_the_grousers;
    });
  };
  evidence_.tones.erase(std::remove_if(evidence_.tones.begin(), evidence_.tones.end(), of_grousers),
                        evidence_.tones.end());
}

/// What the twin misses of the course of every run, how a wheel leaves its print above all, is no finding.
void Gathering::set_left_of_references() {
  Evidence calm;
  calm.baseline = evidence_.baseline;
  calm.runs = runs_.references;
  calm.noise = noise_of(runs_.references);
  calm.lag.resize(calm.runs.size());
  calm.log_deviation.resize(calm.runs.size());
  calm.calm.resize(calm.runs.size());
  std::map<std::pair<Channel, std::string>, std::pair<double, double>> sums;
  for (const Finding& finding : ask_residual(calm, calm.baseline, false).findings) {
    if (finding.feature != "trend" && finding.feature != "turn" && finding.feature != "place") continue;
    auto& [square, count] = sums[{finding.channel, finding.feature}];
    square += finding.size * finding.size;
    count += 1.0;
  }
  for (const auto& [what, sum] : sums) evidence_.left_of_references[what] = std::sqrt(sum.first / sum.second);
}

void Gathering::take_noise_from(const std::vector<Candidate>& explanations) {
  measured_.clear();
  for (const Candidate& explanation : explanations) {
    Left left{runs_.measured, {}};
    for (const RunGrid* run : runs_.measured)
      left.residuals.push_back(residual_of(*run, slow_course(explanation.model, *run)));
    measured_.push_back(std::move(left));
  }
  evidence_.noise = noise_of(runs_.measured);
}

std::vector<NoiseModel> Gathering::noise_of(const std::vector<const RunGrid*>& runs) const {
  const Left& calm = references_.runs.empty() ? measured_.front() : references_;
  const auto least = noise_by_run(calibration_.noise, calm.runs, calm.residuals, floor_, runs);
  std::vector<NoiseModel> noise;
  for (const Left& left : measured_) {
    const NoiseModel pooled = estimate_noise(left.runs, left.residuals, floor_);
    const auto by_run = noise_by_run(pooled, left.runs, left.residuals, floor_, runs);
    const auto at_rest = scatter_at_rest(left.runs, left.residuals);
    const bool first = noise.empty();
    for (std::size_t r = 0; r < runs.size(); ++r) {
      NoiseModel of_run = common_noise(least[r], by_run[r]);
      for (std::size_t c = 0; c < channel_count; ++c)
        of_run[c].rest_offset = std::max(of_run[c].rest_offset, at_rest[c]);
      if (first)
        noise.push_back(of_run);
      else
        for (std::size_t c = 0; c < channel_count; ++c)
          if (of_run[c].deviation < noise[r][c].deviation) noise[r][c] = of_run[c];
    }
  }
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (std::size_t c = 0; c < channel_count; ++c) noise[r][c].start = starts_[c];
    const auto open = left_open_.find(runs[r]);
    for (std::size_t c = 0; open != left_open_.end() && c < channel_count; ++c)
      noise[r][c].run_offset = std::hypot(noise[r][c].run_offset, other_form * open->second[c]);
  }
  return noise;
}

}  // namespace wheel_twin::twin
