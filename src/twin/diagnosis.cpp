#include "twin/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "effects/catalogue.h"
#include "twin/errors_left.h"
#include "twin/explanation.h"
#include "twin/gathering.h"
#include "twin/parallel.h"
#include "twin/recalibration.h"
#include "twin/soil_doubt.h"
#include "twin/steady_diagnosis.h"
#include "twin/steady_runs.h"
#include "twin/tracing.h"
#include "twin/verdict_text.h"

namespace wheel_twin::twin {
namespace {

constexpr double most_bins = 130.0;   // of a run
constexpr double least_share = 0.05;  // of the excess of chi-square that a second effect must explain
constexpr double better = 3.0;        // in the score, that a second effect must be
constexpr double plainly = 2.0;       // in the score, that an effect must be where nothing stands out
constexpr std::size_t refined = 8;    // candidates that are listed
constexpr std::size_t listed_pairs = 4;
constexpr std::size_t other_firsts = 4;  // effects tried beside others where the likest explains nothing
constexpr std::size_t recalibrated = 6;  // candidates that get a soil of their own, without reference runs

double bin_for(const logs::Experiment& experiment) {
  const double rate = std::min(experiment.ft ? experiment.ft->rate : 100.0,
                               experiment.draw_wire ? experiment.draw_wire->rate : 100.0);
  return std::max(0.1, 5.0 / std::max(1.0, rate));
}

bool by_score(const Candidate& a, const Candidate& b) {
  return a.score > b.score;
}

/// Best score first, the soil's uncertainty in the scores of the first `most`.
void rank(const Tracing& tracing, std::vector<Candidate>& candidates, const std::optional<SoilDoubt>& doubt,
          std::size_t most) {
  for (Candidate& c : candidates) c = tracing.scored(c);
  std::sort(candidates.begin(), candidates.end(), by_score);
  if (!doubt) return;
  for (std::size_t i = 0; i < std::min(most, candidates.size()); ++i) {
    doubt->add_to(candidates[i]);
    candidates[i] = tracing.scored(candidates[i]);
  }
  std::sort(candidates.begin(), candidates.end(), by_score);
}

/// Whether a strength of the last effect is told from none by twice its standard error, and its place, if it
/// has one, from the edge of where it may lie: what fits every run's start lies there.
bool last_is_told(const Candidate& candidate) {
  if (candidate.effects.empty()) return false;
  const effects::EffectType& type = effects::find_effect(candidate.effects.back());
  bool strong = false;
  for (std::size_t i = 0; i < type.parameters.size(); ++i) {
    const effects::Parameter& p = type.parameters[i];
    const double value = candidate.values.back()[i], error = candidate.errors.back()[i];
    if (!std::isnan(p.neutral))
      strong = strong || std::abs(value - p.neutral) > 2.0 * error;
    else if (p.name == "position" && value - p.lower < error)
      return false;
  }
  return strong;
}

/// A candidate, how sure it is and how well it explains.
struct Choice {
  Candidate candidate;
  double p = 1.0;  ///< corrected for the size of the catalogue
  Explanation explanation;
};

/// Tracing of one experiment to the effect or the two that explain it best.
class Trace {
 public:
  Trace(const TwinConfig& declared, const NoiseFloor& floor, RunsByRole& runs, Gathering& gathering,
        const DiagnosisOptions& options)
      : runs_(runs),
        gathering_(gathering),
        options_(options),
        tracing_(gathering.evidence(), options.threads) {
    nothing = tracing_.nothing();
    if (!nothing.usable)
      throw Error(declared.name + ": the calibrated twin cannot carry the loads of the measured runs");
    before = nothing.model;
    runs.keep_what_carries(before);
    begin_nuisance_at(gathering_.evidence(), nothing);
    all = tracing_.every_effect(nothing);
    if (!all.empty()) {
      gathering_.take_noise_from(all);
      tracing_.judge_again(nothing);
      for (Candidate& c : all) tracing_.judge_again(c);
      tracing_.set_temperature(*std::min_element(
          all.begin(), all.end(),
          [](const Candidate& x, const Candidate& y) { return x.chi_square < y.chi_square; }));
    }
    if (runs.calibrated())
      doubt_.emplace(gathering.soils(), gathering.evidence());
    else
      recalibration_.emplace(declared, floor, gathering.evidence());
    rank(tracing_, all, doubt_, refined);
    if (recalibration_) {
      in_parallel(std::min(all.size(), recalibrated), options.threads,
                  [&](std::size_t i) { all[i] = (*recalibration_)(all[i]); });
      rank(tracing_, all, doubt_, refined);
    }
    nothing = tracing_.scored(nothing);
    omnibus = ask_residual(gathering.evidence(), nothing.model, false);
    weighing.emplace(gathering, runs, nothing, omnibus, tracing_.count());
    best.candidate = all.empty() ? nothing : all.front();
    best.p = all.empty() ? 1.0 : corrected(nothing, best.candidate);
    best.explanation = (*weighing)(best.candidate);
    // Of what looks alike, what puts the runs held out further off, or is but another soil, is not it.
    const bool something = omnibus.p < options.false_alarm_rate;
    for (std::size_t i = 1; something && best.explanation.refuted() && i < all.size(); ++i) {
      if (all[i].score < all.front().score - better) break;
      Choice next{all[i], corrected(nothing, all[i]), (*weighing)(all[i])};
      if (!next.explanation.refuted()) best = std::move(next);
    }
    if (all.size() > refined) all.resize(refined);
  }

  /// An effect that foretells runs, yet is less likely than none, is none; where nothing stands out it must
  /// be plainly likelier.
  bool likelier() const {
    const double by = omnibus.p < options_.false_alarm_rate ? 0.0 : plainly;
    return best.candidate.score > nothing.score + by;
  }
  bool certified() const {
    return likelier() && best.p < options_.false_alarm_rate && !best.explanation.refuted() &&
           last_is_told(best.candidate);
  }

  /// Is one effect enough? A second must earn its place on runs it was not fitted to as well: by its share of
  /// the whole, by what stood out and is gone, or because one alone explains nothing and the two everything.
  void seek_second() {
    const bool above =
        best.explanation.ratio > good_enough && best.explanation.left.p < options_.false_alarm_rate;
    if (!certified()) return seek_pair();
    if (best.explanation.remains.empty() && best.explanation.unexplained <= 0.5 && !above) return;
    const std::vector<Candidate> singles = all;
    seek_beside(best);
    // Of two effects, a third may look likest to both together, and either alone explains more beside it.
    for (std::size_t i = 1; i < std::min(singles.size(), other_firsts); ++i) {
      if (best.explanation.unexplained <= 0.5) return;
      Choice first{singles[i], corrected(nothing, singles[i]), (*weighing)(singles[i])};
      if (singles[i].score > nothing.score && first.p < options_.false_alarm_rate) seek_beside(first);
    }
  }

  /// The first of two was chosen alone: beside the second another may explain more.
  void seek_first_again() {
    if (best.candidate.effects.size() < 2) return;
    Candidate second;
    second.effects = {best.candidate.effects.back()};
    second.values = {best.candidate.values.back()};
    second.own = best.candidate.own;
    std::vector<Candidate> pairs = tracing_.every_effect(second);
    pairs.erase(std::remove_if(
                    pairs.begin(), pairs.end(),
                    [&](const Candidate& c) { return c.effects.back() == best.candidate.effects.front(); }),
                pairs.end());
    rank(tracing_, pairs, doubt_, listed_pairs);
    pairs.resize(std::min(listed_pairs, pairs.size()));
    all.insert(all.end(), pairs.begin(), pairs.end());
    if (pairs.empty() || pairs.front().score <= best.candidate.score) return;
    Choice other;
    other.candidate = pairs.front();
    other.p = std::max(best.p, corrected(nothing, other.candidate));
    if (other.p >= options_.false_alarm_rate) return;
    other.explanation = (*weighing)(other.candidate);
    if (other.explanation.refuted() ||
        other.explanation.unexplained > std::max(not_all, best.explanation.unexplained))
      return;
    best = std::move(other);
  }

  TwinConfig before;
  Candidate nothing;
  Omnibus omnibus;
  std::vector<Candidate> all;  // that are listed, but nothing
  std::optional<Weighing> weighing;
  Choice best;

 private:
  /// Half of the truth can foretell runs worse than none: where an effect takes most of the excess and still
  /// is not certified, it is tried with another, and the pair must be certified against nothing.
  void seek_pair() {
    const double taken = nothing.chi_square - best.candidate.chi_square;
    if (omnibus.p >= options_.false_alarm_rate || taken < 0.5 * weighing->excess()) return;
    std::vector<Candidate> pairs = tracing_.every_effect(best.candidate);
    rank(tracing_, pairs, doubt_, listed_pairs);
    if (pairs.empty() || !last_is_told(pairs.front())) return;
    Choice both{pairs.front(), 1.0, {}};
    const auto firsts = static_cast<double>(effects::catalogue().size() - 1);
    both.p = std::min(1.0, 0.5 * firsts * corrected(nothing, both.candidate));
    if (both.p >= options_.false_alarm_rate) return;
    both.explanation = (*weighing)(both.candidate);
    if (both.explanation.refuted() || both.explanation.unexplained > not_all) return;
    best = std::move(both);
    pairs.resize(std::min(listed_pairs, pairs.size()));
    all.insert(all.end(), pairs.begin(), pairs.end());
  }

  /// Takes the best pair of `first` and another for the best explanation if it has earned it.
  void seek_beside(const Choice& first) {
    std::vector<Candidate> pairs = tracing_.every_effect(first.candidate);
    rank(tracing_, pairs, doubt_, listed_pairs);
    if (pairs.empty() || pairs.front().score <= first.candidate.score + better ||
        !last_is_told(pairs.front()))
      return;
    Choice both;
    both.candidate = pairs.front();
    both.p = corrected(first.candidate, both.candidate);
    if (both.p >= options_.false_alarm_rate) return;
    both.explanation = (*weighing)(both.candidate);
    if (both.explanation.refuted()) return;
    const double share = (first.candidate.chi_square - both.candidate.chi_square) / weighing->excess();
    // A small share of a large whole is enough where it was plainly wrong without and is right with it.
    const bool mends = first.explanation.ratio > plainly_wrong &&
                       std::max(both.explanation.ratio, both.explanation.ratio_held_out) < good_enough;
    const bool enough = first.explanation.ratio > good_enough && (share > least_share || mends) &&
                        first.explanation.left.p < options_.false_alarm_rate;
    const bool rescues = first.explanation.unexplained > 0.5 && both.explanation.unexplained < 0.5;
    const std::vector<Finding>& remains = first.explanation.remains;
    const bool clears = !remains.empty() && !still_there(remains.front(), both.explanation.left);
    if (!enough && !rescues && !clears) return;
    if (both.explanation.unexplained >= best.explanation.unexplained &&
        both.candidate.score <= best.candidate.score)
      return;
    both.p = std::max(both.p, first.p);
    best = std::move(both);
    pairs.resize(std::min(listed_pairs, pairs.size()));
    all.insert(all.end(), pairs.begin(), pairs.end());
  }

  double corrected(const Candidate& base, const Candidate& candidate) const {
    const auto tests = static_cast<double>(effects::catalogue().size());
    return std::min(1.0, tests * certify(gathering_.evidence(), base, candidate));
  }

  const RunsByRole& runs_;
  Gathering& gathering_;
  const DiagnosisOptions& options_;
  Tracing tracing_;
  std::optional<SoilDoubt> doubt_;
  std::optional<Recalibration> recalibration_;
};

/// All candidates with their probabilities: scores of all explanations, nothing among them; what no
/// explanation brings to the noise floor stays with "none of these".
std::vector<Ranked> probabilities(const Trace& trace, bool found) {
  std::vector<Candidate> all = trace.all;
  all.push_back(trace.nothing);
  std::sort(all.begin(), all.end(), by_score);
  const double highest = all.front().score;
  const auto is_best = [&](const Candidate& c) { return c.effects == trace.best.candidate.effects; };
  if (found) std::stable_partition(all.begin(), all.end(), is_best);
  const double most =
      (trace.certified() ? most_probable(trace.best.p) : 1.0) * (1.0 - trace.best.explanation.unexplained);
  double sum = 0.0;
  for (const Candidate& c : all) sum += std::exp(c.score - highest);
  std::vector<Ranked> ranked;
  for (const Candidate& c : all)
    ranked.push_back({c, is_best(c) ? trace.best.p : 1.0,
                      std::exp(c.score - highest) / sum * (c.effects.empty() ? 1.0 : most)});
  return ranked;
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
  RunsByRole runs = usable_runs(experiment.name, declared, d.grids);
  d.recording_errors = runs.recording_errors;
  const NoiseFloor floor = noise_floor(experiment, grid_options.bin);
  Gathering gathering(declared, runs, floor);
  const Evidence& evidence = gathering.evidence();
  Trace trace(declared, floor, runs, gathering, options);
  trace.seek_second();
  trace.seek_first_again();
  const bool certified = trace.certified();
  const Choice& best = trace.best;
  d.warnings = runs.warnings;
  for (const RunGrid* run : runs.held_out) d.held_out.push_back(run->name);
  d.before = trace.before;
  d.omnibus = trace.omnibus;
  const bool something = d.omnibus.p < options.false_alarm_rate || certified;
  const bool found = certified && best.explanation.unexplained < 0.5;
  d.verdict = found                                      ? "effect_found"
              : !something && d.recording_errors.empty() ? "no_residual"
                                                         : "unexplained";
  d.candidates = probabilities(trace, found);

  d.revised = d.before;
  std::vector<Channel> corrections;
  if (found) {
    d.revised = best.candidate.model;
    for (const Correction& correction : remaining_corrections(d.revised, runs.measured, evidence.noise)) {
      d.revised.corrections.push_back(correction);
      corrections.push_back(correction.channel);
    }
  }
  d.error = errors_of(runs.measured, d.before, d.revised, evidence.noise);
  if (!runs.held_out.empty())
    d.held_out_error = errors_of(runs.held_out, d.before, d.revised, trace.weighing->held_out_noise());
  d.left = ask_residual(evidence, d.revised, found);
  if (found) d.checks = checks_of(best.candidate.effects);
  d.evidence = verdict_text(d, {evidence, trace.nothing, best.candidate, best.explanation, best.p,
                                trace.likelier(), certified, something, corrections});
  return d;
}

}  // namespace wheel_twin::twin
