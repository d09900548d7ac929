#include "twin/steady_selection.h"

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/error.h"
#include "effects/catalogue.h"
#include "twin/parallel.h"

namespace wheel_twin::twin {
namespace {

constexpr double least_share = 0.15;  // of the left-out chi-square that an addition must take away
constexpr double least_gain = 2.0;    // in score
constexpr int first_iterations = 8;   // of a first fit, which tells what to look at closely

class Search {
 public:
  Search(const SteadyEvidence& evidence, const SteadyRuns& runs, const SelectionOptions& options)
      : evidence_(evidence), runs_(runs), options_(options), parts_(parts_of(runs)) {}

  Trial trial(const std::vector<std::string>& effects, const SteadyFit* known) const {
    Trial t;
    t.fit = fit_steady(evidence_, effects, runs_, known);
    if (t.fit.candidate.usable) t.left_out = leave_out(evidence_, t.fit, parts_);
    return t;
  }

  /// Every name on top of `base`, those that fit best left out as well; usable ones only.
  std::vector<Trial> additions(const Trial& base, const std::vector<std::string>& names) const {
    std::vector<Trial> trials;
    for (const std::string& name : names) {
      const auto& has = base.fit.candidate.effects;
      if (std::find(has.begin(), has.end(), name) != has.end()) continue;
      trials.emplace_back();
      trials.back().fit.candidate.effects = has;
      trials.back().fit.candidate.effects.push_back(name);
    }
    std::atomic<int> done{0};
    const double steps = static_cast<double>(trials.size()) + static_cast<double>(options_.close_looks);
    const auto tell = [&] {
      ++done;
      if (options_.progress) options_.progress(done / steps);
    };
    in_parallel(trials.size(), options_.threads, [&](std::size_t i) {
      trials[i].fit =
          fit_steady(evidence_, trials[i].fit.candidate.effects, runs_, &base.fit, first_iterations);
      tell();
    });
    keep(trials, [](const Trial& t) { return t.fit.candidate.usable; });
    std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
      const auto cost = [](const Candidate& c) { return c.chi_square + 2.0 * c.parameters; };
      return cost(a.fit.candidate) < cost(b.fit.candidate);
    });
    if (trials.size() > options_.close_looks) trials.resize(options_.close_looks);
    in_parallel(trials.size(), options_.threads, [&](std::size_t i) {
      const SteadyFit first = trials[i].fit;
      trials[i].fit = fit_steady(evidence_, first.candidate.effects, runs_, &first);
      if (!trials[i].fit.candidate.usable) return;
      trials[i].left_out = leave_out(evidence_, trials[i].fit, parts_);
      tell();
    });
    keep(trials, [](const Trial& t) { return !t.left_out.runs.empty(); });
    return trials;
  }

  double count() const {
    double n = 0.0;
    for (const SteadyRun* run : runs_) n += static_cast<double>(run->grid.windows.size());
    return std::max(1.0, n);
  }

  /// Whether what is foretold better outweighs what was added.
  bool worth(const Trial& without, const Trial& with) const {
    const double before = without.left_out.chi_square, after = with.left_out.chi_square;
    return 0.5 * (before - after) / temperature(with) > least_gain && before - after > least_share * before;
  }

  /// Left-out chi-square over its size: above 1 where even the best explanation misses more than noise.
  double temperature(const Trial& best) const { return std::max(1.0, best.left_out.chi_square / count()); }

  /// Groups left out price a parameter that does not help by about nothing: half the logarithm of the number
  /// of values on top (Schwarz) makes fewer parameters win a draw.
  void score(Trial& t, double temperature) const {
    t.score =
        -0.5 * t.left_out.chi_square / temperature - 0.5 * std::log(count()) * t.fit.candidate.parameters;
  }

 private:
  template <typename Predicate>
  static void keep(std::vector<Trial>& trials, const Predicate& good) {
    trials.erase(std::remove_if(trials.begin(), trials.end(), [&](const Trial& t) { return !good(t); }),
                 trials.end());
  }

  const SteadyEvidence& evidence_;
  const SteadyRuns& runs_;
  const SelectionOptions& options_;
  std::vector<SteadyRuns> parts_;
};

bool lower_chi_square(const Trial& a, const Trial& b) {
  return a.left_out.chi_square < b.left_out.chi_square;
}

}  // namespace

Selection select_effects(const SteadyEvidence& evidence, const SteadyRuns& runs,
                         const std::vector<std::string>& names, const SelectionOptions& options) {
  const Search search(evidence, runs, options);
  Selection s;
  s.nothing = search.trial({}, nullptr);
  if (!s.nothing.fit.candidate.usable || s.nothing.left_out.runs.empty())
    throw Error(evidence.declared.name + ": no soil near the declared one carries the loads of the runs");
  s.chosen = s.nothing;
  s.trials.push_back(s.nothing);
  double worst_p = 0.0;
  const double tests = static_cast<double>(names.size());  // every name might have been the best by chance
  for (std::size_t step = 0;
       step < 2 * options.most_effects && s.chosen.fit.candidate.effects.size() < options.most_effects;
       ++step) {
    std::vector<Trial> trials = search.additions(s.chosen, names);
    if (trials.empty()) break;
    Trial best = *std::min_element(trials.begin(), trials.end(), lower_chi_square);
    s.trials.insert(s.trials.end(), trials.begin(), trials.end());
    double p = tests * certify_left_out(evidence, s.chosen.left_out, best.left_out);
    bool accepted = p < options.false_alarm_rate && search.worth(s.chosen, best);
    if (!accepted && s.chosen.fit.candidate.effects.size() + 2 <= options.most_effects) {
      // Two causes can hide one another: a pair on top of the best single, the second look at twice the
      // price.
      std::vector<Trial> pairs = search.additions(best, names);
      s.trials.insert(s.trials.end(), pairs.begin(), pairs.end());
      const auto pair = std::min_element(pairs.begin(), pairs.end(), lower_chi_square);
      if (pair != pairs.end()) {
        const double p_pair = 2.0 * tests * certify_left_out(evidence, s.chosen.left_out, pair->left_out);
        if (p_pair < options.false_alarm_rate && search.worth(s.chosen, *pair)) {
          accepted = true;
          p = p_pair;
          best = *pair;
        }
      }
    }
    if (!accepted) {
      if (s.chosen.fit.candidate.effects.empty()) worst_p = p;
      break;
    }
    worst_p = std::max(worst_p, p);
    s.chosen = best;
    // What was added first may have stood in for what came later.
    while (s.chosen.fit.candidate.effects.size() > 1) {
      std::vector<Trial> fewer;
      for (std::size_t k = 0; k + 1 < s.chosen.fit.candidate.effects.size(); ++k) {
        std::vector<std::string> effects = s.chosen.fit.candidate.effects;
        effects.erase(effects.begin() + static_cast<std::ptrdiff_t>(k));
        Trial t = search.trial(effects, nullptr);
        if (!t.left_out.runs.empty()) fewer.push_back(std::move(t));
      }
      if (fewer.empty()) break;
      s.trials.insert(s.trials.end(), fewer.begin(), fewer.end());
      const Trial& left = *std::min_element(fewer.begin(), fewer.end(), lower_chi_square);
      if (left.left_out.chi_square > (1.0 + least_share) * s.chosen.left_out.chi_square) break;
      s.chosen = left;
    }
  }
  s.p = std::min(1.0, worst_p);
  const double temperature =
      search.temperature(*std::min_element(s.trials.begin(), s.trials.end(), lower_chi_square));
  for (Trial& t : s.trials) search.score(t, temperature);
  search.score(s.chosen, temperature);
  search.score(s.nothing, temperature);
  std::stable_sort(s.trials.begin(), s.trials.end(),
                   [](const Trial& a, const Trial& b) { return a.score > b.score; });
  return s;
}

namespace {

/// Share of what an effect changes that no change of the soil's own unknowns would do as well.
double own_share(const SteadyEvidence& evidence, const SteadyRuns& runs, const TwinConfig& with_effect,
                 const std::vector<double>& soil) {
  std::vector<double> displacements;
  const auto whitened = [&](const TwinConfig& model, const TwinConfig& reference) {
    Means residuals;
    std::vector<double> out;
    residuals_for_fit(model, reference, runs, displacements, residuals);
    whiten_means(runs, residuals, evidence.noise, out);
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size())));
  };
  const TwinConfig baseline = with_soil(evidence, soil);
  const Eigen::VectorXd start = whitened(baseline, baseline);
  const Eigen::VectorXd change = whitened(with_effect, baseline) - start;
  Eigen::MatrixXd jacobian(start.size(), static_cast<Eigen::Index>(soil.size()));
  for (std::size_t j = 0; j < soil.size(); ++j) {
    std::vector<double> moved = soil;
    moved[j] += 0.2 * evidence.unknowns[j].scale;
    const TwinConfig model = with_soil(evidence, moved);
    jacobian.col(static_cast<Eigen::Index>(j)) = whitened(model, model) - start;
  }
  if (!(change.norm() > 0.0)) return 0.0;
  const Eigen::VectorXd left = change - jacobian * jacobian.colPivHouseholderQr().solve(change);
  return left.norm() / change.norm();
}

}  // namespace

Tellable tellable_effects(const SteadyEvidence& evidence, const SteadyRuns& runs) {
  constexpr double visible = 0.02;  // of the scatter of a channel
  constexpr double own = 0.05;      // of what an effect changes
  constexpr double small = 0.02;    // of its typical size, where it acts linearly
  Tellable result;
  std::vector<double> start;
  for (const Unknown& u : evidence.unknowns) start.push_back(u.start);
  const TwinConfig baseline = with_soil(evidence, start);
  for (const effects::EffectType& type : effects::catalogue()) {
    std::string reason;
    TwinConfig model = baseline;
    model.effects.push_back({type.name, {}});
    for (const effects::Parameter& p : type.parameters) {
      if (p.periodic) reason = "needs the angle of the wheel within a run";
      if (std::isnan(p.neutral) && p.name == "time") reason = "needs the course over time";
      if (std::isnan(p.neutral) && p.name == "position") reason = "needs the course over the travel";
      const double size = std::isnan(p.neutral) || p.neutral >= p.upper ? p.scale : p.neutral + p.scale;
      model.effects.back().values.push_back(std::clamp(size, p.lower, p.upper));
    }
    const Acting acting = acting_effects(model);
    if (std::any_of(acting.ports.rig.begin(), acting.ports.rig.end(),
                    [](const rig::RigPort* port) { return port->coulomb_friction({}) > 0.0; }))
      reason = "shows in how channels fluctuate, not in means";
    if (reason.empty()) {
      double most = 0.0;
      for (const SteadyRun* run : runs) {
        try {
          const std::vector<double> with = predict_means(model, *run),
                                    without = predict_means(baseline, *run);
          for (std::size_t w = 0; w < with.size(); ++w)
            most = std::max(most, std::abs(with[w] - without[w]) /
                                      evidence.noise[index_of(run->grid.windows[w].channel)].total());
        } catch (const Error&) {
          most = 1.0;  // the soil gave way: it was felt
        }
      }
      if (most < visible) reason = "changes no channel that was measured";
    }
    if (reason.empty() && type.parameters.size() == 1) {
      const effects::Parameter& p = type.parameters.front();
      if (p.neutral < p.upper) {
        model.effects.back().values.front() =
            p.neutral + small * (model.effects.back().values.front() - p.neutral);
        if (own_share(evidence, runs, model, start) < own)
          reason = "acts as a change of the soil's own parameters, which are fitted along";
      }
    }
    if (reason.empty())
      result.names.push_back(type.name);
    else
      result.left_aside.push_back(type.name + ": " + reason);
  }
  return result;
}

}  // namespace wheel_twin::twin
