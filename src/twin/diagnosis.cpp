#include "twin/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "effects/catalogue.h"
#include "twin/clock_lag.h"
#include "twin/common_course.h"
#include "twin/errors_left.h"
#include "twin/residual_text.h"
#include "twin/soil_doubt.h"
#include "twin/steady_diagnosis.h"
#include "twin/steady_runs.h"
#include "twin/tracing.h"

namespace wheel_twin::twin {
namespace {

constexpr double most_bins = 130.0;       // of a run
constexpr double mostly_explained = 0.9;  // of the chi-square above what noise has
constexpr double never_explained = 6.0;   // error after over noise floor
constexpr double nearly_gone = 0.95;      // of the squared error of every disturbed channel
constexpr double least_share = 0.05;      // of it that a second effect must explain
constexpr double stands_out = 6.0;        // standard errors of a feature that an explanation must have
constexpr double taken_away = 0.5;        // of such a feature, at least
constexpr double plainly_common = 0.7;    // of what runs have in common over what each has of its own
constexpr double certain = 0.01;          // probability of that by chance
constexpr int fewest_steady_bins = 12;    // of a run
constexpr double lag_tolerance = 0.1;     // s, between runs of one clock
constexpr double lag_error = 0.02;        // s, of one run
constexpr double own_lag = 0.05;          // s, that wire and wrench may have without a clock being late
constexpr std::size_t refined = 8;        // candidates that are listed
constexpr std::size_t listed_pairs = 4;

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

/// How late the draw wire is: against the reference runs, whose own lag is the zero, or without any by what
/// most runs agree on.
void set_lags(const std::vector<const RunGrid*>& references, Evidence& evidence) {
  if (!references.empty()) {
    const ClockLag lag = clock_lag(evidence.runs, references);
    evidence.lag = lag.by_run;
    evidence.lag_error = lag.error;
    return;
  }
  const std::optional<double> common = common_lag(evidence.runs);
  double count = 0.0;
  for (const RunGrid* run : evidence.runs) {
    evidence.lag.emplace_back();
    if (!run->lag || !common || std::abs(run->lag->seconds - *common) > lag_tolerance) continue;
    evidence.lag.back().push_back(run->lag->seconds);
    count += 1.0;
  }
  evidence.lag_error = std::hypot(lag_error, std::sqrt(count) * own_lag);
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

/// How well a candidate explains the experiment.
struct Explanation {
  Omnibus left;                        // what stands out of the residual still
  double ratio = 0.0;                  // worst error over noise floor, runs that were fitted
  double ratio_held_out = 0.0;         // the same, runs held out
  std::optional<double> tone;          // Hz, where a machine hums
  std::optional<CommonCourse> common;  // what follows the clock in all runs
  bool stands = false;                 // what stood out most does so still
  double unexplained = 1.0;            // probability that it is no explanation
};

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
  const auto at_rest = scatter_at_rest(measured.runs, measured.residuals);
  const Left& calm = references.runs.empty() ? measured : references;
  const auto a = noise_by_run(calibration.noise, calm.runs, calm.residuals, floor, runs);
  const auto b = noise_by_run(measured_noise, measured.runs, measured.residuals, floor, runs);
  std::vector<NoiseModel> noise;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    noise.push_back(common_noise(a[r], b[r]));
    for (std::size_t c = 0; c < channel_count; ++c)
      noise[r][c].rest_offset = std::max(noise[r][c].rest_offset, at_rest[c]);
  }
  return noise;
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

/// Whether an effect acts through the contact: it changes how a wheel on soil answers, its lag as well.
bool acts_through_contact(const std::string& effect) {
  const effects::Place place = effects::find_effect(effect).place;
  return place != effects::Place::sensor && place != effects::Place::log;
}

/// The strongest feature that neither soils of another form than the twin's make (levels) nor the effects
/// already named (lags).
const Finding* strongest_feature(const Omnibus& omnibus, const std::vector<std::string>& named) {
  const bool other_contact = std::any_of(named.begin(), named.end(), acts_through_contact);
  for (const Finding& f : omnibus.findings)
    if (f.feature != "level" && !(f.feature == "lag" && other_contact)) return &f;
  return nullptr;
}

/// Whether what stands out most in `before` does so still in `after`.
bool still_there(const Finding* strongest, const Omnibus& after) {
  if (strongest == nullptr || std::abs(strongest->z) < stands_out) return false;
  for (const Finding& f : after.findings)
    if (f.run == strongest->run && f.channel == strongest->channel && f.feature == strongest->feature)
      return std::abs(f.z) > stands_out && std::abs(f.z) > (1.0 - taken_away) * std::abs(strongest->z);
  return false;
}

/// The most that a p-value allows an effect's probability to be, one against one: 1 / (1 - e p ln p), the
/// bound of Sellke, Bayarri and Berger (2001).
double most_probable(double p) {
  constexpr double e = 2.718281828459045;
  return p < 1.0 / e ? 1.0 / (1.0 - e * p * std::log(std::max(p, 1e-300))) : 0.5;
}

/// Best score first, the soil's uncertainty in the scores of the first `most`.
void rank(const Tracing& tracing, std::vector<Candidate>& candidates, const std::optional<SoilDoubt>& doubt,
          std::size_t most) {
  const auto by_score = [](const Candidate& x, const Candidate& y) { return x.score > y.score; };
  for (Candidate& c : candidates) c = tracing.scored(c);
  std::sort(candidates.begin(), candidates.end(), by_score);
  if (!doubt) return;
  for (std::size_t i = 0; i < std::min(most, candidates.size()); ++i) {
    doubt->add_to(candidates[i]);
    candidates[i] = tracing.scored(candidates[i]);
  }
  std::sort(candidates.begin(), candidates.end(), by_score);
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
  evidence.offset_freedom = std::max(3.0, static_cast<double>(references.size() + measured.size()) - 2.0);
  set_lags(references, evidence);
  for (std::size_t r = 0; r < measured.size(); ++r) {
    evidence.log_deviation.push_back(log_deviation_by_stretch(*measured[r], residuals[r].bins));
    evidence.calm.push_back(evidence.fluctuation.known
                                ? predicted_log_deviation(d.before, *measured[r], evidence.fluctuation_of(r))
                                : LogDeviation{});
  }

  Tracing tracing(evidence, options.threads);
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
  std::optional<SoilDoubt> doubt;
  if (calibrated) doubt.emplace(declared, calibration, evidence);
  rank(tracing, singles, doubt, refined);
  nothing = tracing.scored(nothing);
  d.omnibus = ask_residual(evidence, nothing.model, false);
  std::vector<Candidate> all = singles;
  if (all.size() > refined) all.resize(refined);

  const double tests = static_cast<double>(effects::catalogue().size());
  const auto corrected = [&](const Candidate& base, const Candidate& c) {
    return std::min(1.0, tests * certify(evidence, base, c));
  };

  const std::vector<NoiseModel> held_out_noise = noise_of_runs(held_out);
  std::vector<const RunGrid*> all_runs = measured;
  all_runs.insert(all_runs.end(), held_out.begin(), held_out.end());
  const double excess = std::max(1.0, nothing.chi_square - tracing.count());
  const auto weigh = [&](const Candidate& c) {
    Explanation e;
    e.left = ask_residual(evidence, c.model, !c.effects.empty());
    const Errors errors = errors_of(measured, nothing.model, c.model, evidence.noise);
    e.ratio = worst_ratio(errors);
    e.ratio_held_out =
        held_out.empty() ? 0.0 : worst_ratio(errors_of(held_out, nothing.model, c.model, held_out_noise));
    std::vector<Residual> remainder;
    for (const RunGrid* run : all_runs) remainder.push_back(residual_of(*run, slow_course(c.model, *run)));
    // Friction is read from how much channels fluctuate, whatever the cause; it does not hum.
    if (sticks(c.model)) e.tone = common_tone(all_runs, remainder);
    e.common = common_course(all_runs, remainder);
    if (e.common && (e.common->p > certain || e.common->share < plainly_common)) e.common.reset();
    e.stands = !d.omnibus.findings.empty() && still_there(&d.omnibus.findings.front(), e.left);
    const double explained = 1.0 - (c.chi_square - tracing.count()) / excess;
    e.unexplained = e.tone || e.common || e.stands || std::max(e.ratio, e.ratio_held_out) > never_explained
                        ? 1.0
                    : (explained > mostly_explained || least_gone(errors) > nearly_gone)
                        ? 0.0
                        : 1.0 / (1.0 + std::exp(-(e.ratio - 0.5 * (good_enough + plainly_wrong)) / 0.1));
    return e;
  };

  Candidate best = singles.empty() ? nothing : singles.front();
  double p_best = singles.empty() ? 1.0 : corrected(nothing, best);
  // An effect that foretells runs, yet is less likely than none, is none.
  const bool likelier = best.score > nothing.score;
  const bool certified = likelier && p_best < options.false_alarm_rate;
  const bool something = d.omnibus.p < options.false_alarm_rate || certified;
  Explanation explanation = weigh(best);
  if (certified && explanation.left.p < options.false_alarm_rate) {
    // Is one effect enough? A second must earn its place on runs it was not fitted to as well: by its share
    // of the whole, by what stood out and is gone, or because one alone explains nothing and the two
    // everything.
    const Finding* feature = strongest_feature(explanation.left, best.effects);
    const bool shows = feature != nullptr && std::abs(feature->z) > stands_out;
    std::vector<Candidate> pairs;
    if (explanation.ratio > good_enough || explanation.unexplained > 0.5 || shows)
      pairs = tracing.every_effect(best);
    rank(tracing, pairs, doubt, listed_pairs);
    if (!pairs.empty() && pairs.front().score > best.score + 3.0) {
      const double p_pair = corrected(best, pairs.front());
      const Explanation both = weigh(pairs.front());
      const double gain = (best.chi_square - pairs.front().chi_square) / excess;
      const bool rescues = explanation.unexplained > 0.5 && both.unexplained < 0.5;
      const bool clears = shows && !still_there(feature, both.left);
      const bool enough = explanation.ratio > good_enough && gain > least_share;
      if (p_pair < options.false_alarm_rate && (enough || rescues || clears)) {
        best = pairs.front();
        explanation = both;
        p_best = std::max(p_best, p_pair);
        all.insert(all.end(), pairs.begin(),
                   pairs.begin() + static_cast<std::ptrdiff_t>(std::min(listed_pairs, pairs.size())));
      }
    }
  }
  const double unexplained = explanation.unexplained;
  const std::optional<double>& tone = explanation.tone;
  const std::optional<CommonCourse>& common = explanation.common;
  if (!something)
    d.verdict = d.recording_errors.empty() ? "no_residual" : "unexplained";
  else if (certified && unexplained < 0.5)
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
  const double most = certified ? most_probable(p_best) : 1.0;
  double sum = 0.0;
  for (const Candidate& c : all) sum += std::exp(c.score - highest);
  for (const Candidate& c : all) {
    Ranked ranked;
    ranked.candidate = c;
    ranked.probability =
        std::exp(c.score - highest) / sum * (c.effects.empty() ? 1.0 : most * (1.0 - unexplained));
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
  if (!held_out.empty()) d.held_out_error = errors_of(held_out, d.before, d.revised, held_out_noise);
  d.left = ask_residual(evidence, d.revised, d.verdict == "effect_found");

  if (!something) {
    d.evidence = fmt::format(
        "The residual of the calibrated twin is noise: no feature of any run stands out (corrected p = "
        "{:.2g}) and no effect of the catalogue {} (best: {}, corrected p = {:.2g}).",
        d.omnibus.p, likelier ? "predicts runs that it was not fitted to" : "is likelier than none",
        effect_list(best.effects), p_best);
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
    else if (!certified)
      d.evidence +=
          fmt::format("No effect of the catalogue {}: the best is {} (corrected p = {:.2g}).",
                      likelier ? "foretells runs that it was not fitted to" : "is likelier than none",
                      effect_list(best.effects), p_best);
    else if (explanation.stands)
      d.evidence += fmt::format(
          "{} foretells runs that it was not fitted to (corrected p = {:.2g}) but does not have what stands "
          "out most: "
          "the {} of {} in {}.",
          effect_list(best.effects), p_best, d.omnibus.findings.front().feature,
          name_of(d.omnibus.findings.front().channel), d.omnibus.findings.front().run);
    else
      d.evidence += fmt::format(
          "No effect of the catalogue brings it to the noise level: the best, {}, leaves {:.1f} times the "
          "noise floor (corrected p = {:.2g}).",
          effect_list(best.effects), std::max(explanation.ratio, explanation.ratio_held_out), p_best);
    if (tone)
      d.evidence += fmt::format(
          " Most of what a channel fluctuates by is one tone of {:.3g} Hz, the same in most runs: a machine, "
          "not friction.",
          *tone);
    if (common)
      d.evidence += fmt::format(
          " What {} leaves of {} follows the clock in all runs alike ({:.2g} {} in the root mean square, "
          "steepest at {:.1f} s, where it changes by {:+.2g} {} in two seconds): something happens then that "
          "it does not have.",
          effect_list(best.effects), name_of(common->channel),
          shown_factor(common->channel) * common->deviation, shown_unit_of(common->channel), common->time,
          shown_factor(common->channel) * common->change, shown_unit_of(common->channel));
  }
  d.evidence = told(d.recording_errors) + d.evidence;
  return d;
}

}  // namespace wheel_twin::twin
