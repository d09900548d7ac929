#include "twin/verdict_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "effects/catalogue.h"
#include "twin/residual_text.h"

namespace wheel_twin::twin {
namespace {

/// What no effect of the catalogue does.
const char* lacks(const Grounds& g) {
  if (!g.likelier) return "is likelier than none";
  if (g.explanation.misleads) return "brings the twin nearer to the runs held out";
  return g.explanation.of_soil ? "is told from another soil, which needs reference runs"
                               : "foretells runs that it was not fitted to";
}

std::string nothing_found(const Diagnosis& d, const Grounds& g) {
  return fmt::format(
      "The residual of the calibrated twin is noise: no feature of any run stands out (corrected p = {:.2g}) "
      "and no effect of the catalogue {} (best: {}, corrected p = {:.2g}).",
      d.omnibus.p, lacks(g), effect_list(g.best.effects), g.p_best);
}

std::string found(const Diagnosis& d, const Grounds& g) {
  std::string runner = "none";
  for (const Ranked& r : d.candidates)
    if (r.candidate.effects != g.best.effects) {
      runner = fmt::format("{} (probability {:.2g})", effect_list(r.candidate.effects), r.probability);
      break;
    }
  const std::string text = fmt::format(
      "The residual shows: {}{}. {} explains it, fitted on one half of the runs and predicting the other "
      "(corrected p = {:.2g}); runner-up: {}.",
      describe(d.omnibus), correlations(g.evidence, g.nothing.model), effect_list(g.best.effects), g.p_best,
      runner);
  if (g.corrections.empty()) return text;
  std::vector<std::string> names;
  for (const Channel channel : g.corrections) names.emplace_back(name_of(channel));
  return text + fmt::format(
                    " What the effect leaves of the level of {} is a smooth function of slip and load; the "
                    "revised twin adds it as an empirical correction, which has no physical name.",
                    fmt::join(names, ", "));
}

std::string no_explanation(const Diagnosis& d, const Grounds& g) {
  const std::string best = effect_list(g.best.effects);
  if (g.evidence.runs.size() < 2)
    return "With one measured run no effect can be put to the test on a run it was not fitted to.";
  if (!g.certified)
    return fmt::format("No effect of the catalogue {}: the best is {} (corrected p = {:.2g}).", lacks(g),
                       best, g.p_best);
  if (g.explanation.stands) {
    const Finding& strongest = d.omnibus.findings.front();
    return fmt::format(
        "{} foretells runs that it was not fitted to (corrected p = {:.2g}) but does not have what stands "
        "out "
        "most: the {} of {} in {}.",
        best, g.p_best, strongest.feature, name_of(strongest.channel), strongest.run);
  }
  if (const auto remains = systematic(g.explanation.remains); remains && remains->tone)
    return fmt::format(
        "{} foretells runs that it was not fitted to (corrected p = {:.2g}) but no effect hums: a machine "
        "does, at {}.",
        best, g.p_best, frequency_of(*remains->tone));
  else if (remains)
    return fmt::format(
        "{} foretells runs that it was not fitted to (corrected p = {:.2g}) but leaves too much of the {} of "
        "{} in {} ({:+.1f} standard errors).",
        best, g.p_best, remains->feature, name_of(remains->channel), remains->run, remains->z);
  return fmt::format(
      "No effect of the catalogue brings it to the noise level: the best, {}, leaves {:.1f} times the noise "
      "floor (corrected p = {:.2g}).",
      best, std::max(g.explanation.ratio, g.explanation.ratio_held_out), g.p_best);
}

std::string unexplained(const Diagnosis& d, const Grounds& g) {
  std::string text = fmt::format("The residual is more than noise: {}{}. ", describe(d.omnibus),
                                 correlations(g.evidence, g.nothing.model)) +
                     no_explanation(d, g);
  if (g.explanation.tone)
    text += fmt::format(
        " Most of what a channel fluctuates by is one tone of {:.3g} Hz, the same in most runs: a machine, "
        "not "
        "friction.",
        *g.explanation.tone);
  if (const auto& common = g.explanation.common)
    text += fmt::format(
        " What {} leaves of {} follows the clock in all runs alike ({:.2g} {} in the root mean square, "
        "steepest at {:.1f} s, where it changes by {:+.2g} {} in two seconds): something happens then that "
        "it "
        "does not have.",
        effect_list(g.best.effects), name_of(common->channel),
        shown_factor(common->channel) * common->deviation, shown_unit_of(common->channel), common->time,
        shown_factor(common->channel) * common->change, shown_unit_of(common->channel));
  return text;
}

}  // namespace

std::vector<Check> checks_of(const std::vector<std::string>& effects) {
  std::vector<Check> checks;
  for (const std::string& name : effects) {
    const effects::EffectType& type = effects::find_effect(name);
    checks.push_back({name, type.advice + " " + type.identifiability});
  }
  return checks;
}

std::string verdict_text(const Diagnosis& diagnosis, const Grounds& grounds) {
  std::string text = told(diagnosis.recording_errors);
  if (!grounds.something) return text + nothing_found(diagnosis, grounds);
  return text +
         (diagnosis.verdict == "effect_found" ? found(diagnosis, grounds) : unexplained(diagnosis, grounds));
}

}  // namespace wheel_twin::twin
