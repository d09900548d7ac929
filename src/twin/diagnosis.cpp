#include "twin/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "base/error.h"
#include "base/progress.h"
#include "effects/catalogue.h"
#include "twin/errors_left.h"
#include "twin/parallel.h"
#include "twin/steady_diagnosis.h"
#include "twin/steady_runs.h"

namespace wheel_twin::twin {
namespace {

constexpr double most_bins = 130.0;       // of a run
constexpr double mostly_explained = 0.9;  // of the chi-square above what noise has
constexpr double never_explained = 6.0;   // error after over noise floor
constexpr double nearly_gone = 0.95;      // of the squared error of every disturbed channel
constexpr double least_share = 0.05;      // of it that a second effect must explain
constexpr int fewest_steady_bins = 12;    // of a run
constexpr double lag_tolerance = 0.1;     // s, between runs of one clock
constexpr std::size_t refined = 8;        // candidates that are listed
constexpr std::size_t fitted_singles = 14, fitted_pairs = 7;  // of those that promise most

double bin_for(const logs::Experiment& experiment) {
  const double rate = std::min(experiment.ft ? experiment.ft->rate : 100.0,
                               experiment.draw_wire ? experiment.draw_wire->rate : 100.0);
  return std::max(0.1, 5.0 / std::max(1.0, rate));
}

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
  for (std::size_t c = 0; c < channel_count; ++c)
    if (measured[c].deviation > noise[c].deviation) {
      noise[c].deviation = measured[c].deviation;
      noise[c].keep = measured[c].keep;
    }
  return noise;
}

/// Runs and what a twin leaves of them: what noise is estimated from.
struct Left {
  std::vector<const RunGrid*> runs;
  std::vector<Residual> residuals;
};

/// Noise of each of `runs` by what the calibrated twin leaves of the reference runs (empty: none) and by what
/// the best explanation leaves of the measured ones.
std::vector<NoiseModel> noise_of(const std::vector<const RunGrid*>& runs, const Calibration& calibration,
                                 const Left& references, const Left& measured, const NoiseFloor& floor) {
  const NoiseModel measured_noise = estimate_noise(measured.runs, measured.residuals, floor);
  const Left& calm = references.runs.empty() ? measured : references;
  const auto a = noise_by_run(calibration.noise, calm.runs, calm.residuals, floor, runs);
  const auto b = noise_by_run(measured_noise, measured.runs, measured.residuals, floor, runs);
  std::vector<NoiseModel> noise;
  for (std::size_t r = 0; r < runs.size(); ++r) noise.push_back(common_noise(a[r], b[r]));
  return noise;
}

std::string effect_list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " + ") + name;
  return text.empty() ? "nothing" : text;
}

class Tracing {
 public:
  Tracing(const Evidence& evidence, const DiagnosisOptions& options)
      : evidence_(evidence), options_(options) {
    runs_.resize(evidence.runs.size());
    std::iota(runs_.begin(), runs_.end(), std::size_t{0});
    double blocks = 0.0;
    for (const RunGrid* run : evidence.runs) blocks += run->bins() * run->bin / 6.0;
    price_ = 0.5 * std::log(std::max(3.0, blocks));
  }

  /// Fits every effect of the catalogue on top of `base`, best score first.
  std::vector<Candidate> every_effect(const Candidate& base) const {
    std::vector<std::string> names;
    for (const effects::EffectType& type : effects::catalogue())
      if (std::find(base.effects.begin(), base.effects.end(), type.name) == base.effects.end())
        names.push_back(type.name);
    // A look at every effect, then a fit of those that promise most.
    Progress progress(base.effects.empty() ? "tracing effects" : "tracing pairs",
                      static_cast<double>(names.size()));
    std::atomic<int> done{0};
    const auto with = [&](const std::string& name) {
      std::vector<std::string> all = base.effects;
      all.push_back(name);
      return all;
    };
    std::vector<double> foretold(names.size());
    in_parallel(names.size(), options_.threads, [&](std::size_t i) {
      foretold[i] = foretold_chi_square(evidence_, with(names[i]), runs_, base.values);
      progress.update(0.5 * ++done);
    });
    std::vector<std::size_t> order(names.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return foretold[a] < foretold[b]; });
    order.resize(std::min(order.size(), base.effects.empty() ? fitted_singles : fitted_pairs));
    std::vector<Candidate> candidates(order.size());
    in_parallel(order.size(), options_.threads, [&](std::size_t i) {
      candidates[i] = scored(fit_candidate(evidence_, with(names[order[i]]), runs_, base.values));
      progress.update(0.5 * (done += 1));
    });
    candidates.erase(
        std::remove_if(candidates.begin(), candidates.end(), [](const Candidate& c) { return !c.usable; }),
        candidates.end());
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
    return candidates;
  }

  /// Chi-square under the noise as it is now known.
  void judge_again(Candidate& candidate) const {
    candidate.run_chi_square = chi_squares(evidence_, candidate.model, runs_, candidate.fluctuates);
    candidate.chi_square =
        std::accumulate(candidate.run_chi_square.begin(), candidate.run_chi_square.end(), 0.0);
  }

  double count() const {
    double sum = 0.0;
    for (std::size_t r = 0; r < evidence_.runs.size(); ++r)
      sum += static_cast<double>(run_residuals(evidence_, r, evidence_.baseline, false).size());
    return sum;
  }

  Candidate nothing() const { return scored(fit_candidate(evidence_, {}, runs_)); }

  Candidate scored(Candidate candidate) const {
    candidate.score = -0.5 * candidate.chi_square / temperature_ - price_ * candidate.parameters;
    return candidate;
  }

  /// Chi-square counts six channels that share one fluctuation, and what the model misses: scores are cooled
  /// by how far the best explanation is from chi-square one.
  void set_temperature(const Candidate& best) {
    temperature_ = std::max(3.0, 3.0 * best.chi_square / std::max(1.0, count()));
  }

 private:
  const Evidence& evidence_;
  DiagnosisOptions options_;
  std::vector<std::size_t> runs_;
  double price_ = 3.0;
  double temperature_ = 3.0;
};

std::string describe(const Finding& f) {
  return fmt::format("{} of {} in {}: {:.3g} {} ({:+.1f} standard errors)", f.feature, name_of(f.channel),
                     f.run, f.size,
                     f.feature == "lag"           ? "s"
                     : f.feature == "fluctuation" ? "in log"
                                                  : unit_of(f.channel),
                     f.z);
}

/// What the residual looks like, for a person who has to write the missing effect.
std::string describe(const Omnibus& omnibus) {
  if (omnibus.findings.empty()) return "nothing stands out";
  std::string text;
  std::set<std::string> told;
  for (const Finding& f : omnibus.findings) {
    if (std::abs(f.z) < 4.0 || told.size() >= 5) break;
    if (!told.insert(fmt::format("{}/{}", f.feature, name_of(f.channel))).second) continue;
    text += (text.empty() ? "" : "; ") + describe(f);
  }
  return text.empty() ? "nothing stands out" : text;
}

/// Correlation of the level of each run's residual with slip, load and temperature.
std::string correlations(const Evidence& evidence, const TwinConfig& model) {
  std::string text;
  for (const Channel channel : all_channels) {
    std::vector<double> level, slip;
    for (const RunGrid* run : evidence.runs) {
      const Residual residual = residual_of(*run, simulate(model, *run));
      double sum = 0.0;
      int count = 0;
      for (int i = 0; i < run->bins(); ++i)
        if (run->moving[static_cast<std::size_t>(i)] && std::isfinite(residual.bins(index_of(channel), i))) {
          sum += residual.bins(index_of(channel), i);
          ++count;
        }
      if (count == 0) continue;
      level.push_back(sum / count);
      slip.push_back(run->declared.slip);
    }
    if (level.size() < 4) continue;
    const double n = static_cast<double>(level.size());
    const double ml = std::accumulate(level.begin(), level.end(), 0.0) / n,
                 ms = std::accumulate(slip.begin(), slip.end(), 0.0) / n;
    double ls = 0.0, ll = 0.0, ss = 0.0;
    for (std::size_t i = 0; i < level.size(); ++i) {
      ls += (level[i] - ml) * (slip[i] - ms);
      ll += (level[i] - ml) * (level[i] - ml);
      ss += (slip[i] - ms) * (slip[i] - ms);
    }
    const double r = ll > 0.0 && ss > 0.0 ? ls / std::sqrt(ll * ss) : 0.0;
    if (std::abs(r) > 0.8 && std::sqrt(ll / n) > 2.0 * evidence.noise.front()[index_of(channel)].run_offset)
      text += fmt::format("; the level of {} follows slip (correlation {:+.2f})", name_of(channel), r);
  }
  return text;
}

/// Runs that can be explained, errors of recording put right; tells of both. Throws Error when most runs are
/// no logs of what is declared.
std::vector<const RunGrid*> usable_runs(const TwinConfig& declared, Diagnosis& d) {
  std::vector<RunGrid*> moving[2];  // references, others
  for (RunGrid& grid : d.grids) {
    if (steady_bins_of(grid) < fewest_steady_bins)
      d.warnings.push_back(fmt::format("{}: no steady part ({:.3g} s at constant speeds), left out",
                                       grid.name, steady_bins_of(grid) * grid.bin));
    else
      moving[grid.declared.role == logs::Role::reference ? 0 : 1].push_back(&grid);
  }
  std::vector<const RunGrid*> usable;
  std::size_t all = 0;
  std::string reason;
  for (const auto& runs : moving) {
    for (const RecordingError& error : put_right(runs, declared)) d.recording_errors.push_back(error);
    for (const RunGrid* run : runs) {
      ++all;
      const std::string why = contradiction(*run);
      if (why.empty()) {
        usable.push_back(run);
        continue;
      }
      reason = run->name + ": " + why;
      d.warnings.push_back(reason + "; left out");
    }
  }
  if (2 * usable.size() < all)
    throw Error(fmt::format("{}: {} of {} runs are no logs of what is declared ({})", d.experiment,
                            all - usable.size(), all, reason));
  return usable;
}

std::string told(const std::vector<RecordingError>& errors) {
  std::string text;
  for (const RecordingError& error : errors) {
    text += fmt::format("{}{} (in {}", text.empty() ? "Recording: " : "; ", error.what, error.runs.front());
    text += error.runs.size() > 1 ? fmt::format(" to {})", error.runs.back()) : ")";
  }
  return text.empty() ? text : text + ". It was put right before what follows. ";
}

}  // namespace

Diagnosis diagnose(const logs::Experiment& experiment, const DiagnosisOptions& options) {
  Diagnosis d;
  d.experiment = experiment.name;
  GridOptions grid_options;
  grid_options.bin = bin_for(experiment);
  grid_options.most_bins = most_bins;
  d.grids = read_runs(experiment, grid_options);
  if (!d.grids.empty()) grid_options.bin = d.grids.front().bin;
  if (known_by_means(d.grids)) {
    diagnose_by_means(experiment, options, d);
    return d;
  }
  const TwinConfig declared = declared_twin(experiment);
  std::vector<const RunGrid*> references, measured, held_out;
  for (const RunGrid* run : usable_runs(declared, d)) {
    const RunGrid& grid = *run;
    (grid.declared.role == logs::Role::reference  ? references
     : grid.declared.role == logs::Role::measured ? measured
                                                  : held_out)
        .push_back(&grid);
  }
  if (measured.empty())
    throw Error(fmt::format("{}: no measured run to diagnose{}", experiment.name,
                            d.warnings.empty() ? "" : " (" + d.warnings.front() + ")"));
  const bool calibrated = references.size() >= 2;
  if (!calibrated) d.warnings.push_back("no reference runs: the baseline is fitted together with the effect");
  // Some measured runs are never fitted, so that what is claimed can be scored on them.
  if (held_out.empty() && measured.size() >= 5) {
    std::vector<const RunGrid*> kept;
    for (std::size_t i = 0; i < measured.size(); ++i) (i % 4 == 2 ? held_out : kept).push_back(measured[i]);
    measured = kept;
  }
  for (const RunGrid* run : held_out) d.held_out.push_back(run->name);

  const NoiseFloor floor = noise_floor(experiment, grid_options.bin);
  const Calibration calibration = calibrate(declared, calibrated ? references : measured, floor);
  d.before = calibration.model;

  d.before.table = std::make_shared<terramechanics::ContactTable>(d.before.wheel, d.before.soil);

  Evidence evidence;
  evidence.baseline = d.before;
  evidence.runs = measured;
  Left left_of_measured{measured, {}}, left_of_references;
  std::vector<Residual>& residuals = left_of_measured.residuals;
  for (const RunGrid* run : measured) residuals.push_back(residual_of(*run, simulate(d.before, *run)));
  if (calibrated) {
    left_of_references.runs = references;
    for (const RunGrid* run : references)
      left_of_references.residuals.push_back(residual_of(*run, simulate(d.before, *run)));
    evidence.fluctuation = fit_fluctuation(d.before, references, left_of_references.residuals);
    evidence.beyond = fluctuation_beyond(evidence.fluctuation, d.before, references,
                                         left_of_references.residuals, measured);
  } else {
    evidence.baseline.corrections.clear();
    d.before = evidence.baseline;
    evidence.nuisance = unknowns_beside_shape(calibration);
  }
  const auto noise_of_runs = [&](const std::vector<const RunGrid*>& runs) {
    return noise_of(runs, calibration, left_of_references, left_of_measured, floor);
  };
  evidence.noise = noise_of_runs(measured);
  // Wire and wrench need not fluctuate together at no lag: where there are reference runs, theirs is the
  // zero.
  const std::optional<double> reference_lag = calibrated ? common_lag(references) : 0.0;
  const std::optional<double> measured_lag = common_lag(measured);
  for (std::size_t r = 0; r < measured.size(); ++r) {
    evidence.log_deviation.push_back(log_deviation_by_stretch(*measured[r], residuals[r].bins));
    evidence.calm.push_back(evidence.fluctuation.known
                                ? predicted_log_deviation(d.before, *measured[r], evidence.fluctuation_of(r))
                                : LogDeviation{});
    const std::optional<Lag>& lag = measured[r]->lag;
    const bool agrees =
        lag && measured_lag && reference_lag && std::abs(lag->seconds - *measured_lag) < lag_tolerance;
    evidence.lag.push_back(agrees ? std::optional<double>(lag->seconds - *reference_lag) : std::nullopt);
  }
  evidence.lag_error = 0.02;

  Tracing tracing(evidence, options);
  Candidate nothing = tracing.nothing();
  if (!nothing.usable)
    throw Error(experiment.name + ": the calibrated twin cannot carry the loads of the measured runs");
  d.before = nothing.model;
  begin_nuisance_at(evidence, nothing);

  std::vector<Candidate> singles = tracing.every_effect(nothing);
  if (!singles.empty()) {
    // What the best explanation leaves tells the noise better than what the baseline leaves.
    residuals.clear();
    for (const RunGrid* run : measured)
      residuals.push_back(residual_of(*run, slow_course(singles.front().model, *run)));
    evidence.noise = noise_of_runs(measured);
    tracing.judge_again(nothing);
    for (Candidate& c : singles) tracing.judge_again(c);
    const auto lowest =
        std::min_element(singles.begin(), singles.end(),
                         [](const Candidate& x, const Candidate& y) { return x.chi_square < y.chi_square; });
    tracing.set_temperature(*lowest);
  }
  for (Candidate& c : singles) c = tracing.scored(c);
  std::sort(singles.begin(), singles.end(),
            [](const Candidate& x, const Candidate& y) { return x.score > y.score; });
  nothing = tracing.scored(nothing);
  d.omnibus = ask_residual(evidence, nothing.model, false);
  std::vector<Candidate> all = singles;
  if (all.size() > refined) all.resize(refined);

  const double tests = static_cast<double>(effects::catalogue().size());
  const auto corrected = [&](const Candidate& base, const Candidate& c) {
    return std::min(1.0, tests * certify(evidence, base, c));
  };

  double p_best = singles.empty() ? 1.0 : corrected(nothing, singles.front());
  Candidate best = singles.empty() ? nothing : singles.front();
  const double excess = std::max(1.0, nothing.chi_square - tracing.count());
  const bool something = d.omnibus.p < options.false_alarm_rate || p_best < options.false_alarm_rate;
  const Errors single_errors = errors_of(measured, nothing.model, best.model, evidence.noise);
  if (something && p_best < options.false_alarm_rate) {
    // Is one effect enough? A second must earn its place on runs it was not fitted to as well.
    const Omnibus left = ask_residual(evidence, best.model, best.fluctuates);
    if (left.p < options.false_alarm_rate && worst_ratio(single_errors) > good_enough) {
      std::vector<Candidate> pairs = tracing.every_effect(best);
      for (Candidate& c : pairs) c = tracing.scored(c);
      if (!pairs.empty() && pairs.front().score > best.score + 3.0) {
        const double p_pair = corrected(best, pairs.front());
        const double gain = (best.chi_square - pairs.front().chi_square) / excess;
        if (p_pair < options.false_alarm_rate && gain > least_share) {
          best = pairs.front();
          p_best = std::max(p_best, p_pair);
          all.insert(all.end(), pairs.begin(),
                     pairs.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(4, pairs.size())));
        }
      }
    }
  }
  const Errors errors = errors_of(measured, nothing.model, best.model, evidence.noise);
  const double ratio = worst_ratio(errors);
  // Friction is read from how much channels fluctuate, whatever the cause; it does not hum.
  std::optional<double> tone;
  if (sticks(best.model)) {
    std::vector<Residual> left;
    for (const RunGrid* run : measured) left.push_back(residual_of(*run, slow_course(best.model, *run)));
    tone = common_tone(measured, left);
  }
  const double explained = 1.0 - (best.chi_square - tracing.count()) / excess;
  const double unexplained =
      tone ? 1.0
      : ratio < never_explained && (explained > mostly_explained || least_gone(errors) > nearly_gone)
          ? 0.0
          : 1.0 / (1.0 + std::exp(-(ratio - 0.5 * (good_enough + plainly_wrong)) / 0.1));
  if (!something)
    d.verdict = d.recording_errors.empty() ? "no_residual" : "unexplained";
  else if (p_best < options.false_alarm_rate && unexplained < 0.5)
    d.verdict = "effect_found";
  else
    d.verdict = "unexplained";

  // Probabilities: scores of all explanations, nothing among them; what no explanation brings to the noise
  // floor stays with "none of these".
  all.push_back(nothing);
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  if (d.verdict == "effect_found")
    std::stable_partition(all.begin(), all.end(),
                          [&](const Candidate& c) { return c.effects == best.effects; });
  const double highest = std::max_element(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
                           return a.score < b.score;
                         })->score;
  double sum = 0.0;
  for (const Candidate& c : all) sum += std::exp(c.score - highest);
  for (const Candidate& c : all) {
    Ranked ranked;
    ranked.candidate = c;
    ranked.probability = std::exp(c.score - highest) / sum * (c.effects.empty() ? 1.0 : 1.0 - unexplained);
    ranked.p_value = c.effects == best.effects ? p_best : 1.0;
    d.candidates.push_back(ranked);
  }
  d.revised = d.before;
  std::string corrected_channels;
  if (d.verdict == "effect_found") {
    d.revised = best.model;
    for (const Correction& correction : remaining_corrections(best.model, measured, evidence.noise)) {
      d.revised.corrections.push_back(correction);
      corrected_channels +=
          (corrected_channels.empty() ? "" : ", ") + std::string(name_of(correction.channel));
    }
  }
  d.error = errors_of(measured, d.before, d.revised, evidence.noise);
  if (!held_out.empty()) d.held_out_error = errors_of(held_out, d.before, d.revised, noise_of_runs(held_out));
  d.left = ask_residual(evidence, d.revised, d.verdict == "effect_found" && best.fluctuates);

  if (!something) {
    d.evidence = fmt::format(
        "The residual of the calibrated twin is noise: no feature of any run stands out (corrected p = "
        "{:.2g}) and no effect of the catalogue predicts runs that it was not fitted to (best: {}, corrected "
        "p = {:.2g}).",
        d.omnibus.p, effect_list(best.effects), p_best);
  } else if (d.verdict == "effect_found") {
    std::string runner = "none";
    for (const Ranked& r : d.candidates)
      if (r.candidate.effects != best.effects) {
        runner = fmt::format("{} (probability {:.2g})", effect_list(r.candidate.effects), r.probability);
        break;
      }
    d.evidence = fmt::format(
        "The residual shows: {}{}. {} explains it, fitted on one half of the runs and predicting the other "
        "(corrected p = {:.2g}); runner-up: {}.",
        describe(d.omnibus), correlations(evidence, nothing.model), effect_list(best.effects), p_best,
        runner);
    for (const std::string& name : best.effects) {
      const effects::EffectType& type = effects::find_effect(name);
      d.evidence += fmt::format(" {}: {} {}", name, type.advice, type.identifiability);
    }
    if (!corrected_channels.empty())
      d.evidence += fmt::format(
          " What the effect leaves of the level of {} is a smooth function of slip and load; the revised "
          "twin adds "
          "it as an empirical correction, which has no physical name.",
          corrected_channels);
  } else {
    d.evidence = fmt::format("The residual is more than noise: {}{}. ", describe(d.omnibus),
                             correlations(evidence, nothing.model));
    if (measured.size() < 2)
      d.evidence += "With one measured run no effect can be put to the test on a run it was not fitted to.";
    else if (p_best >= options.false_alarm_rate)
      d.evidence += fmt::format(
          "No effect of the catalogue foretells runs that it was not fitted to: the best is {} (corrected p "
          "= "
          "{:.2g}).",
          effect_list(best.effects), p_best);
    else
      d.evidence += fmt::format(
          "No effect of the catalogue brings it to the noise level: the best, {}, leaves {:.1f} times the "
          "noise floor (corrected p = {:.2g}).",
          effect_list(best.effects), ratio, p_best);
    if (tone)
      d.evidence += fmt::format(
          " Most of what a channel fluctuates by is one tone of {:.3g} Hz, the same in most runs: a machine, "
          "not friction.",
          *tone);
  }
  d.evidence = told(d.recording_errors) + d.evidence;
  return d;
}

}  // namespace wheel_twin::twin
