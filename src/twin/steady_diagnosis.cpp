#include "twin/steady_diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <set>

#include "base/error.h"
#include "base/progress.h"
#include "effects/catalogue.h"
#include "twin/baseline.h"
#include "twin/metrics.h"
#include "twin/parallel.h"
#include "twin/plate_fit.h"
#include "twin/residual_text.h"
#include "twin/separating_run.h"
#include "twin/steady_evidence.h"
#include "twin/steady_selection.h"
#include "twin/verdict_text.h"

namespace wheel_twin::twin {
namespace {

constexpr std::size_t fewest_runs = 3;
constexpr std::size_t enough_straight = 5;  // for steered runs to stay out
constexpr double good_enough = 1.3;         // error over scatter
constexpr double plainly_wrong = 2.0;       // error over scatter at which nothing is explained
constexpr double mostly_explained = 0.9;    // of the chi-square above what scatter has
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Runs {
  std::vector<SteadyRun> all;
  SteadyRuns measured, held_out, outside;  // into `all`; measured holds the references as well
};

void sort_runs(const logs::Experiment& experiment, const std::vector<RunGrid>& grids, Diagnosis& d,
               Runs& runs) {
  for (std::size_t i = 0; i < experiment.runs.size(); ++i) {
    try {
      runs.all.push_back(steady_run(experiment.runs[i], grids[i].name, experiment.wheel.radius));
    } catch (const Error& error) {
      d.warnings.push_back(fmt::format("{}; left out", error.what()));
    }
  }
  std::size_t straight = 0;
  for (const SteadyRun& run : runs.all)
    if (run.grid.declared.role == logs::Role::measured && is_straight(run.grid.declared)) ++straight;
  for (const SteadyRun& run : runs.all) {
    const logs::Run& declared = run.grid.declared;
    if (straight >= enough_straight && !is_straight(declared))
      runs.outside.push_back(&run);
    else if (declared.role == logs::Role::held_out)
      runs.held_out.push_back(&run);
    else
      runs.measured.push_back(&run);
  }
  if (!runs.outside.empty())
    d.warnings.push_back(fmt::format(
        "{} steered runs are left out of the diagnosis, which is of the {} straight ones; the revised twin's "
        "errors on them are given apart",
        runs.outside.size(), runs.measured.size()));
}

SteadyEvidence evidence_of(const logs::Experiment& experiment, const Runs& runs, Diagnosis& d) {
  SteadyEvidence e;
  e.declared = declared_twin(experiment);
  e.declared.rig.steering_limit = 1.5;  // of the contact; the rig that was driven had its own
  double pressure = 1.0, exponent = 0.1;
  const std::vector<PressCurve> curves = read_press_curves(experiment);
  if (!curves.empty()) {
    try {
      const PlateFit fit = fit_plates(curves, experiment.wheel.width);
      e.declared.soil = soil_of_fit(experiment.soil, fit);
      e.reference_depth = fit.reference_depth;
      // The bed of a run is one more preparation, which differs as those of the tests do.
      pressure = std::hypot(fit.relative_error_at_width, fit.between_tests_pressure);
      exponent = std::hypot(fit.n.standard_error, fit.between_tests_exponent);
    } catch (const Error& error) {
      d.warnings.push_back(fmt::format("plate tests not used: {}", error.what()));
    }
  }
  e.unknowns = soil_unknowns(e.declared.soil, std::max(0.02, pressure), std::max(0.02, exponent));
  e.noise = steady_noise(experiment, runs.all);
  return e;
}

double rmse(const std::vector<double>& residuals) {
  double sum = 0.0;
  for (const double r : residuals) sum += r * r;
  return residuals.empty() ? nan : std::sqrt(sum / static_cast<double>(residuals.size()));
}

/// Residuals of a channel over the rows that pass.
template <typename Filter>
std::vector<double> collect(const std::vector<SteadyRow>& rows, Channel channel,
                            double SteadyRow::Value::*twin, const Filter& filter) {
  std::vector<double> residuals;
  for (const SteadyRow& row : rows) {
    const auto value = row.values.find(channel);
    if (value != row.values.end() && filter(row) && std::isfinite(value->second.*twin))
      residuals.push_back(value->second.measured - value->second.*twin);
  }
  return residuals;
}

template <typename Filter>
Errors errors_between(const std::vector<SteadyRow>& rows, const SteadyNoise& noise,
                      double SteadyRow::Value::*before, double SteadyRow::Value::*after,
                      const Filter& filter) {
  Errors errors;
  for (const Channel channel : all_channels) {
    const double b = rmse(collect(rows, channel, before, filter));
    if (std::isfinite(b))
      errors[channel] = {b, rmse(collect(rows, channel, after, filter)), noise[index_of(channel)].total()};
  }
  return errors;
}

const auto every = [](const SteadyRow&) { return true; };
const auto drives = [](const SteadyRow& row) { return row.slip > 0.05; };

/// The load that was read leads the twin: it is no channel to score then.
bool scored(const SteadyRun& run, Channel channel) {
  return channel != Channel::normal_load || !run.grid.declared.averages->normal_load;
}

std::vector<double> means_or_nan(const TwinConfig& model, const SteadyRun& run) {
  try {
    return predict_means(model, run);
  } catch (const Error&) {
    return std::vector<double>(run.grid.windows.size(), nan);
  }
}

SteadyRow row_of(const SteadyRun& run, const TwinConfig& declared, const TwinConfig& before,
                 const TwinConfig& after) {
  SteadyRow row;
  row.run = run.grid.name;
  row.group = run.group();
  row.slip = run.grid.declared.slip;
  row.load = run.grid.declared.load;
  row.steering_angle = run.grid.declared.steering_angle;
  const auto a = means_or_nan(declared, run), b = means_or_nan(before, run), c = means_or_nan(after, run);
  for (std::size_t w = 0; w < run.grid.windows.size(); ++w) {
    const WindowMean& window = run.grid.windows[w];
    if (scored(run, window.channel)) row.values[window.channel] = {window.mean, a[w], b[w], c[w], nan};
  }
  return row;
}

void set_left_out(const SteadyRuns& runs, const Means& residuals, SteadyReport& report) {
  for (std::size_t i = 0; i < residuals.size(); ++i)
    for (SteadyRow& row : report.rows)
      if (row.run == runs[i]->grid.name)
        for (std::size_t w = 0; w < residuals[i].size(); ++w) {
          const auto value = row.values.find(runs[i]->grid.windows[w].channel);
          if (value != row.values.end()) value->second.left_out = value->second.measured - residuals[i][w];
        }
}

std::string label_of(const SteadyRuns& part) {
  std::set<std::string> groups;
  for (const SteadyRun* run : part) groups.insert(run->group().empty() ? run->grid.name : run->group());
  std::string label;
  for (const std::string& group : groups) label += (label.empty() ? "" : ", ") + group;
  return label;
}

/// Every part foretold by a selection that never saw it, in its choice of effects neither.
void foretell_parts(const SteadyEvidence& evidence, const SteadyRuns& runs, const Tellable& tellable,
                    const DiagnosisOptions& options, SteadyReport& report) {
  const std::vector<SteadyRuns> parts = parts_of(runs);
  std::vector<Means> residuals(parts.size());
  report.parts.resize(parts.size());
  Progress progress("leaving groups out", static_cast<double>(parts.size()));
  std::atomic<int> done{0};
  in_parallel(parts.size(), options.threads, [&](std::size_t k) {
    SteadyRuns others;
    for (std::size_t j = 0; j < parts.size(); ++j)
      if (j != k) others.insert(others.end(), parts[j].begin(), parts[j].end());
    report.parts[k] = label_of(parts[k]);
    try {
      SelectionOptions selection_options;
      selection_options.false_alarm_rate = options.false_alarm_rate;
      const Selection s = select_effects(evidence, others, tellable.names, selection_options);
      residuals[k] = residuals_of(s.chosen.fit.candidate.model, s.chosen.fit.baseline, parts[k]);
      report.parts[k] += ": " + effect_list(s.chosen.fit.candidate.effects);
    } catch (const Error& error) {
      report.parts[k] += fmt::format(": not foretold, {}", error.what());
    }
    progress.update(++done);
  });
  for (std::size_t k = 0; k < parts.size(); ++k) set_left_out(parts[k], residuals[k], report);
}

/// `before`: the twin without effects, its soil fitted without the group.
void score_left_out(const SteadyEvidence& evidence, const LeftOut& before, SteadyReport& report) {
  const auto score = [&](const auto& filter) {
    Errors errors = errors_between(report.rows, evidence.noise, &SteadyRow::Value::before,
                                   &SteadyRow::Value::left_out, filter);
    for (auto& [channel, error] : errors) {
      std::vector<double> values;
      for (std::size_t r = 0; r < before.runs.size(); ++r)
        for (std::size_t w = 0; w < before.residuals[r].size(); ++w)
          if (before.runs[r]->grid.windows[w].channel == channel)
            for (const SteadyRow& row : report.rows)
              if (row.run == before.runs[r]->grid.name && filter(row))
                values.push_back(before.residuals[r][w]);
      error.before = rmse(values);
    }
    return errors;
  };
  report.left_out = score(every);
  report.left_out_driving = score(drives);
  for (const auto& [channel, error] : report.left_out_driving) {
    std::vector<double> off;
    for (const SteadyRow& row : report.rows) {
      if (!drives(row) || row.values.count(channel) == 0) continue;
      double sum = 0.0, count = 0.0;
      for (const SteadyRow& other : report.rows)
        if (drives(other) && other.values.count(channel) > 0 &&
            (row.group.empty() ? other.run != row.run : other.group != row.group))
          sum += other.values.at(channel).measured, count += 1.0;
      if (count > 0.0) off.push_back(row.values.at(channel).measured - sum / count);
    }
    if (!off.empty()) report.constant_driving[channel] = rmse(off);
  }
}

double worst_ratio(const Errors& errors) {
  double worst = 0.0;
  for (const auto& [channel, error] : errors)
    if (std::isfinite(error.after)) worst = std::max(worst, error.after / error.noise_floor);
  return worst;
}

std::string errors_text(const Errors& errors, double ChannelError::*member) {
  std::string text;
  for (const auto& [channel, error] : errors)
    text += fmt::format("{}{} {:.3g} {}", text.empty() ? "" : ", ", name_of(channel),
                        shown_factor(channel) * (error.*member), shown_unit_of(channel));
  return text;
}

/// Probability of each effect: of all explanations that have it.
double probability_of(const std::string& name, const std::vector<Ranked>& candidates) {
  double sum = 0.0;
  for (const Ranked& r : candidates) {
    const auto& e = r.candidate.effects;
    if (std::find(e.begin(), e.end(), name) != e.end()) sum += r.probability;
  }
  return sum;
}

}  // namespace

void diagnose_by_means(const logs::Experiment& experiment, const DiagnosisOptions& options, Diagnosis& d) {
  d.steady.emplace();
  SteadyReport& report = *d.steady;
  Runs runs;
  sort_runs(experiment, d.grids, d, runs);
  const auto measured = static_cast<std::size_t>(std::count_if(
      runs.measured.begin(), runs.measured.end(), [](const SteadyRun* r) { return !r->reference; }));
  if (measured < fewest_runs)
    throw Error(fmt::format("{}: {} measured run{} with averages, {} are needed to leave some out",
                            experiment.name, measured, measured == 1 ? "" : "s", fewest_runs));
  const SteadyEvidence evidence = evidence_of(experiment, runs, d);
  const Tellable tellable = tellable_effects(evidence, runs.measured);
  report.left_aside = tellable.left_aside;

  SelectionOptions selection_options;
  selection_options.false_alarm_rate = options.false_alarm_rate;
  selection_options.threads = options.threads;
  Selection s;
  {
    Progress progress("tracing effects", 1.0);
    selection_options.progress = [&progress](double share) { progress.update(share); };
    s = select_effects(evidence, runs.measured, tellable.names, selection_options);
  }
  d.before = s.nothing.fit.candidate.model;
  d.revised = s.chosen.fit.candidate.model;
  for (const SteadyRun* run : runs.measured)
    if (!run->reference) report.rows.push_back(row_of(*run, evidence.declared, d.before, d.revised));
  if (options.choose_without_group) {
    foretell_parts(evidence, runs.measured, tellable, options, report);
  } else {
    set_left_out(s.chosen.left_out.runs, s.chosen.left_out.residuals, report);
    for (const SteadyRuns& part : parts_of(runs.measured))
      report.parts.push_back(label_of(part) + ": " + effect_list(s.chosen.fit.candidate.effects));
  }
  score_left_out(evidence, s.nothing.left_out, report);
  const std::vector<std::string>& found = s.chosen.fit.candidate.effects;

  const double left = s.chosen.left_out.chi_square, at_first = s.nothing.left_out.chi_square;
  double count = 0.0;
  for (const SteadyRun* run : runs.measured) count += static_cast<double>(run->grid.windows.size());
  const double explained = 1.0 - (left - count) / std::max(1.0, at_first - count);
  const double ratio = worst_ratio(report.left_out);
  double sum = 0.0;
  for (const Trial& t : s.trials) sum += std::exp(t.score - s.trials.front().score);
  for (const Trial& t : s.trials)
    d.candidates.push_back({t.fit.candidate, t.fit.candidate.effects == found ? s.p : 1.0,
                            std::exp(t.score - s.trials.front().score) / sum});
  for (Ranked& r : d.candidates) {
    for (const Trial& t : s.trials)
      if (t.fit.candidate.effects == r.candidate.effects) r.candidate.score = t.score;
  }
  std::stable_partition(d.candidates.begin(), d.candidates.end(),
                        [&](const Ranked& r) { return r.candidate.effects == found; });
  double least_probable = 1.0;
  for (const std::string& name : found) {
    d.effect_probability[name] = probability_of(name, d.candidates);
    least_probable = std::min(least_probable, d.effect_probability[name]);
  }
  const Errors nothing_left = errors_between(report.rows, evidence.noise, &SteadyRow::Value::before,
                                             &SteadyRow::Value::before, every);
  const bool close = ratio < plainly_wrong || explained > mostly_explained;
  if (!found.empty() && close && least_probable >= 0.5)
    d.verdict = "effect_found";
  else if (found.empty() && worst_ratio(nothing_left) < good_enough)
    d.verdict = "no_residual";
  else
    d.verdict = "unexplained";

  d.error =
      errors_between(report.rows, evidence.noise, &SteadyRow::Value::before, &SteadyRow::Value::after, every);
  report.declared = errors_between(report.rows, evidence.noise, &SteadyRow::Value::declared,
                                   &SteadyRow::Value::after, every);
  const auto apart = [&](const SteadyRuns& some) {
    std::vector<SteadyRow> rows;
    for (const SteadyRun* run : some) rows.push_back(row_of(*run, evidence.declared, d.before, d.revised));
    return errors_between(rows, evidence.noise, &SteadyRow::Value::before, &SteadyRow::Value::after, every);
  };
  report.outside = apart(runs.outside);
  report.outside_runs = runs.outside.size();
  if (!runs.held_out.empty()) {
    d.held_out_error = apart(runs.held_out);
    for (const SteadyRun* run : runs.held_out) d.held_out.push_back(run->grid.name);
  } else {
    d.held_out_error = report.left_out;
    for (const SteadyRow& row : report.rows) d.held_out.push_back(row.run);
  }
  std::string moved;  // what the soil had to give to meet the runs without an effect
  for (std::size_t j = 0; j < evidence.unknowns.size(); ++j) {
    const Unknown& u = evidence.unknowns[j];
    const double widths = (s.nothing.fit.soil[j] - u.prior) / u.prior_deviation;
    if (std::abs(widths) > 1.0)
      moved += fmt::format("{}{} {:.3g} to {:.3g} ({:+.1f} prior deviations)", moved.empty() ? "" : ", ",
                           u.name, u.prior, s.nothing.fit.soil[j], widths);
  }
  for (std::size_t j = 0; j < evidence.unknowns.size(); ++j)
    report.soil.push_back(fmt::format("{} {:.4g} ± {:.2g}", evidence.unknowns[j].name, s.chosen.fit.soil[j],
                                      s.chosen.fit.soil_error[j]));

  report.survey = survey_logs(experiment);

  const std::string residual = describe_by_slip(report.rows, evidence.noise, &SteadyRow::Value::before);
  const std::string remainder =
      describe_correlations(report.rows, evidence.noise, &SteadyRow::Value::left_out);
  const std::string separate = separating_run(experiment, evidence, s, runs.measured);
  const auto chosen_without = static_cast<std::size_t>(
      std::count_if(report.parts.begin(), report.parts.end(), [&](const std::string& part) {
        const std::string end = ": " + effect_list(found);
        return part.size() >= end.size() && part.compare(part.size() - end.size(), end.size(), end) == 0;
      }));
  d.evidence = fmt::format(
      "Twin as declared, with the plates' soil where there are plates: {}. With the soil fitted to the runs "
      "and no effect: {}. ",
      errors_text(report.declared, &ChannelError::before), errors_text(d.error, &ChannelError::before));
  if (!moved.empty()) d.evidence += fmt::format("For that the soil moved: {}. ", moved);
  if (!residual.empty()) d.evidence += "What that leaves: " + residual + ". ";
  if (d.verdict == "no_residual") {
    d.evidence += fmt::format(
        "That is within {:.1f} times the scatter of repeated runs, and no effect foretells groups left out "
        "better (best: corrected p = {:.2g}).",
        good_enough, s.p);
  } else if (found.empty()) {
    d.evidence += fmt::format(
        "It is more than scatter, but no effect of the catalogue foretells groups left out better by a "
        "margin beyond chance (best: {}, corrected p = {:.2g}).",
        s.trials.empty() ? "none" : effect_list(s.trials.front().fit.candidate.effects), s.p);
  } else {
    d.evidence += fmt::format(
        "{} foretell{} groups left out where the soil alone does not (corrected p = {:.2g}, sign-flip test "
        "over runs and channels): left out, with the effects chosen without the group as well, {}; scatter "
        "of "
        "repeated runs: {}. The same choice is made without the group in {} of {} groups.",
        effect_list(found), found.size() == 1 ? "s" : "", s.p,
        errors_text(report.left_out, &ChannelError::after),
        errors_text(report.left_out, &ChannelError::noise_floor), chosen_without, report.parts.size());
    if (d.verdict == "unexplained")
      d.evidence +=
          least_probable < 0.5
              ? " Several explanations do about as well, so that none is named; they stand among the "
                "candidates."
              : fmt::format(" Yet it leaves {:.1f} times that scatter: something else acts.", ratio);
    d.checks = checks_of(found);
  }
  if (!remainder.empty()) d.evidence += " What is left on groups left out: " + remainder + ".";
  if (!separate.empty()) d.evidence += " " + separate;
}

}  // namespace wheel_twin::twin
