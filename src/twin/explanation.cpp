#include "twin/explanation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "effects/catalogue.h"
#include "twin/errors_left.h"

namespace wheel_twin::twin {
namespace {

constexpr double mostly_explained = 0.9;  // of the chi-square above what noise has
constexpr double never_explained = 6.0;   // error after over noise floor
constexpr double nearly_gone = 0.95;      // of the squared error of every disturbed channel
constexpr double stands_out = 6.0;        // standard errors of a feature that an explanation must have
constexpr double turn_stands_out = 4.5;   // of one that comes once a turn, which nothing else makes
constexpr double taken_away = 0.5;        // of such a feature, at least
constexpr double leavings = 0.2;          // of a feature, that the effect which makes it may leave
constexpr double worse = 1.5;             // error after over before, of a channel that is put off
constexpr double misleading = 0.1;        // squared floors that runs held out may be further off
constexpr double plainly_common = 0.7;    // of what runs have in common over what each has of its own
constexpr double certain = 0.01;          // probability of that by chance
constexpr double worth_a_word = 0.5;      // of the noise of a bin, that it must have

/// Whether an effect acts through the contact: it changes how a wheel on soil answers, its lag as well.
bool acts_through_contact(const std::string& effect) {
  const effects::Place place = effects::find_effect(effect).place;
  return place != effects::Place::sensor && place != effects::Place::log;
}

bool changes_soil(const std::string& effect) {
  return effects::find_effect(effect).place == effects::Place::soil;
}

/// Without reference runs a run's offset is mostly what the soil's form misses, in all runs alike: one draw,
/// of which two deviations are nothing unusual.
std::vector<NoiseModel> judged_by(std::vector<NoiseModel> noise, const RunsByRole& runs) {
  constexpr double not_unusual = 2.0;
  if (!runs.calibrated())
    for (NoiseModel& of_run : noise)
      for (ChannelNoise& channel : of_run) channel.run_offset *= not_unusual;
  return noise;
}

bool same_place(const Finding& a, const Finding& b) {
  return a.run == b.run && a.channel == b.channel && a.feature == b.feature;
}

bool stands(const Finding& f) {
  return std::abs(f.z) > (f.feature == "turn" ? turn_stands_out : stands_out);
}

}  // namespace

std::vector<Finding> plain_features(const Omnibus& after, const Omnibus& before, const TwinConfig& model) {
  const bool rubs = sticks(model);
  const bool other_contact =
      std::any_of(model.effects.begin(), model.effects.end(),
                  [](const EffectSetting& setting) { return acts_through_contact(setting.name); });
  const auto is_rough = [&](const Finding& f) {
    if (f.feature == "fluctuation") return rubs || (other_contact && f.channel != Channel::normal_load);
    return f.feature == "lag" && other_contact;
  };
  const auto is_leaving = [&](const Finding& f) {
    return std::any_of(before.findings.begin(), before.findings.end(), [&](const Finding& b) {
      return same_place(b, f) && std::abs(f.z) < leavings * std::abs(b.z);
    });
  };
  std::vector<Finding> plain;
  for (const Finding& f : after.findings)
    if (f.feature != "level" && !is_rough(f) && stands(f) && !is_leaving(f)) plain.push_back(f);
  return plain;
}

std::optional<Finding> systematic(const std::vector<Finding>& features) {
  for (const Finding& f : features) {
    const bool of_many = f.tone || f.feature == "lag" || f.feature == "zero";
    const bool again = std::any_of(features.begin(), features.end(), [&](const Finding& g) {
      return g.run != f.run && g.channel == f.channel && g.feature == f.feature;
    });
    if (of_many || again) return f;
  }
  return std::nullopt;
}

bool still_there(const Finding& feature, const Omnibus& after) {
  for (const Finding& f : after.findings)
    if (same_place(f, feature)) return stands(f) && std::abs(f.z) > (1.0 - taken_away) * std::abs(feature.z);
  return false;
}

double most_probable(double p) {
  constexpr double e = 2.718281828459045;
  return p < 1.0 / e ? 1.0 / (1.0 - e * p * std::log(std::max(p, 1e-300))) : 0.5;
}

Weighing::Weighing(const Gathering& gathering, const RunsByRole& runs, const Candidate& nothing,
                   const Omnibus& omnibus, double count)
    : evidence_(gathering.evidence()),
      runs_(runs),
      nothing_(nothing),
      omnibus_(omnibus),
      count_(count),
      excess_(std::max(1.0, nothing.chi_square - count)),
      noise_(judged_by(evidence_.noise, runs)),
      held_out_noise_(gathering.noise_of(runs.held_out)) {}

Explanation Weighing::operator()(const Candidate& candidate) const {
  Explanation e;
  const std::vector<const RunGrid*> judged = runs_.judged();
  std::vector<Residual> remainder;
  try {
    for (const RunGrid* run : judged)
      remainder.push_back(residual_of(*run, slow_course(candidate.model, *run)));
  } catch (const Error&) {
    e.ratio_held_out = std::numeric_limits<double>::infinity();  // it sinks where it was not fitted
    e.misleads = true;
    return e;
  }
  e.left = ask_residual(evidence_, candidate.model, !candidate.effects.empty());
  const Errors left = errors_of(runs_.measured, nothing_.model, candidate.model, evidence_.noise);
  const Errors errors = with_floors_of(noise_, runs_.measured, left);
  const bool fits = std::all_of(errors.begin(), errors.end(), [](const auto& entry) {
    return !(entry.second.before > plainly_wrong * entry.second.noise_floor);
  });
  e.of_soil = !runs_.calibrated() && fits &&
              std::any_of(candidate.effects.begin(), candidate.effects.end(), changes_soil) &&
              plain_features(omnibus_, {}, nothing_.model).empty();
  e.ratio = worst_ratio(errors);
  if (!runs_.held_out.empty()) {
    const Errors held_out =
        errors_of(runs_.held_out, nothing_.model, candidate.model, judged_by(held_out_noise_, runs_));
    e.ratio_held_out = worst_ratio(held_out);
    e.misleads = added(held_out) > misleading;
  }
  // Friction is read from how much channels fluctuate, whatever the cause; it does not hum.
  if (sticks(candidate.model)) e.tone = common_tone(judged, remainder);
  e.common = common_course(judged, remainder);
  if (e.common) {
    const double least = worth_a_word * noise_.front()[index_of(e.common->channel)].deviation;
    if (e.common->p > certain || e.common->share < plainly_common || e.common->deviation < least)
      e.common.reset();
  }
  e.stands = !omnibus_.findings.empty() && still_there(omnibus_.findings.front(), e.left);
  e.remains = plain_features(e.left, omnibus_, candidate.model);
  const bool puts_off = std::any_of(errors.begin(), errors.end(), [](const auto& entry) {
    const ChannelError& error = entry.second;
    return error.after > plainly_wrong * error.noise_floor && error.after > worse * error.before;
  });
  const double explained = 1.0 - (candidate.chi_square - count_) / excess_;
  if (e.tone || e.common || e.stands || systematic(e.remains) || puts_off ||
      std::max(e.ratio, e.ratio_held_out) > never_explained)
    e.unexplained = 1.0;
  else if (explained > mostly_explained || least_gone(errors) > nearly_gone)
    e.unexplained = std::max(e.ratio, e.ratio_held_out) > plainly_wrong ? not_all : 0.0;
  else
    e.unexplained = 1.0 / (1.0 + std::exp(-(e.ratio - 0.5 * (good_enough + plainly_wrong)) / 0.1));
  return e;
}

}  // namespace wheel_twin::twin
