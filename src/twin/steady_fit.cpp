#include "twin/steady_fit.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"
#include "base/random.h"
#include "effects/catalogue.h"

namespace wheel_twin::twin {
namespace {

constexpr double prior_widths = 3.0;  // of a parameter's scale
constexpr int soil_draws = 10;
constexpr int sign_flips = 100000;

struct Layout {
  std::vector<const effects::EffectType*> types;
  explicit Layout(const std::vector<std::string>& names) {
    for (const std::string& name : names) types.push_back(&effects::find_effect(name));
  }
  std::vector<std::vector<double>> split(const std::vector<double>& x, std::size_t at) const {
    std::vector<std::vector<double>> values;
    for (const auto* type : types) {
      values.emplace_back();
      for (const effects::Parameter& p : type->parameters)
        values.back().push_back(std::clamp(x[at++], p.lower, p.upper));
    }
    return values;
  }
};

/// Start values of one effect: the size that matters to either side, shapes on a short grid.
std::vector<std::vector<double>> starts_of(const effects::EffectType& type) {
  std::vector<std::vector<double>> starts = {{}};
  bool first = true;
  for (const effects::Parameter& p : type.parameters) {
    std::vector<double> choices;
    if (std::isnan(p.neutral))
      choices = {std::clamp(0.2 * p.scale, p.lower, p.upper), std::clamp(p.scale, p.lower, p.upper)};
    else if (p.neutral >= p.upper)  // a depth: the shallower, the stronger
      choices = {p.lower + 0.3 * p.scale, p.lower + p.scale};
    else if (first)
      for (const double size : {0.5, -0.5, 2.0, -2.0}) {
        const double value = p.neutral + size * p.scale;
        if (value >= p.lower && value <= p.upper) choices.push_back(value);
      }
    else
      choices = {std::clamp(p.neutral + 0.5 * p.scale, p.lower, p.upper)};
    if (!std::isnan(p.neutral)) first = false;
    std::vector<std::vector<double>> longer;
    for (const auto& start : starts)
      for (const double choice : choices) {
        longer.push_back(start);
        longer.back().push_back(choice);
      }
    starts = std::move(longer);
  }
  return starts;
}

TwinConfig with_effects(TwinConfig model, const Layout& layout,
                        const std::vector<std::vector<double>>& values) {
  for (std::size_t k = 0; k < layout.types.size(); ++k)
    model.effects.push_back({layout.types[k]->name, values[k]});
  return model;
}

}  // namespace

std::vector<Unknown> soil_unknowns(const terramechanics::Soil& s, double pressure_deviation,
                                   double exponent_deviation) {
  return {{"ln_pressure", 0.0, -4.0, 4.0, 0.2, 0.0, pressure_deviation},
          {"n", s.n, 0.3, 2.5, 0.1, s.n, exponent_deviation},
          {"c", s.c, 0.0, 2e4, 100.0, s.c, 100.0},
          {"phi", s.phi, 0.15, 1.1, 0.05, s.phi, 0.15},
          {"ln_K", 0.0, -3.0, 3.0, 0.2, 0.0, 0.7},
          {"c1", s.c1, 0.0, 0.95, 0.05, s.c1, 0.15},
          {"c2", s.c2, -0.8, 0.8, 0.05, s.c2, 0.1}};
}

TwinConfig with_soil(const SteadyEvidence& evidence, const std::vector<double>& x) {
  TwinConfig m = evidence.declared;
  const double factor = std::exp(x[0]) * std::pow(evidence.reference_depth, m.soil.n - x[1]);
  m.soil.k_c *= factor;
  m.soil.k_phi *= factor;
  m.soil.n = x[1];
  m.soil.c = x[2];
  m.soil.phi = x[3];
  m.soil.K *= std::exp(x[4]);
  m.soil.c1 = x[5];
  m.soil.c2 = x[6];
  return m;
}

SteadyFit fit_steady(const SteadyEvidence& evidence, const std::vector<std::string>& names,
                     const SteadyRuns& runs, const SteadyFit* known, int iterations, std::size_t looks_kept) {
  const Layout layout(names);
  std::vector<Unknown> unknowns = evidence.unknowns;
  const std::size_t soil_count = unknowns.size();
  for (const auto* type : layout.types)
    for (const effects::Parameter& p : type->parameters) {
      Unknown u;
      u.name = p.name;
      u.lower = p.lower;
      u.upper = p.upper;
      u.scale = p.scale;
      const bool to_neutral = !std::isnan(p.neutral) && p.neutral < p.upper;
      u.prior = to_neutral ? p.neutral : p.scale;
      u.prior_deviation = p.neutral >= p.upper ? 1e9 : prior_widths * p.scale;
      unknowns.push_back(u);
    }
  std::vector<double> displacements;  // where the last evaluation found the hub, run by run
  const ResidualFunction function = [&](const std::vector<double>& x, std::vector<double>& out) {
    const TwinConfig baseline = with_soil(evidence, x);
    const TwinConfig model = with_effects(baseline, layout, layout.split(x, soil_count));
    Means residuals;
    if (!residuals_for_fit(model, baseline, runs, displacements, residuals)) return false;
    whiten_means(runs, residuals, evidence.noise, out);
    return true;
  };

  std::vector<std::vector<double>> starts = {{}};
  if (known != nullptr)
    for (std::size_t k = 0; k < known->candidate.values.size() && k < layout.types.size(); ++k)
      starts.front().insert(starts.front().end(), known->candidate.values[k].begin(),
                            known->candidate.values[k].end());
  for (std::size_t k = known != nullptr ? known->candidate.values.size() : 0; k < layout.types.size(); ++k) {
    std::vector<std::vector<double>> longer;
    for (const auto& start : starts)
      for (const auto& more : starts_of(*layout.types[k])) {
        longer.push_back(start);
        longer.back().insert(longer.back().end(), more.begin(), more.end());
      }
    starts = std::move(longer);
  }
  // A fit with fewer effects may have bent the soil far to make up for them: soils drawn from the prior are
  // starts too.
  const bool refit = known != nullptr && known->candidate.effects == names;
  std::vector<std::vector<double>> soils(1);
  for (std::size_t j = 0; j < soil_count; ++j)
    soils.front().push_back(known != nullptr ? known->soil[j] : unknowns[j].start);
  Random random(1, 0);
  for (int draw = 0; !refit && draw < soil_draws; ++draw) {
    soils.emplace_back();
    for (std::size_t j = 0; j < soil_count; ++j)
      soils.back().push_back(unknowns[j].prior + unknowns[j].prior_deviation * random.normal());
  }
  const auto with_start = [&](const std::vector<double>& values, const std::vector<double>& soil) {
    std::vector<Unknown> started = unknowns;
    for (std::size_t j = 0; j < soil_count; ++j)
      started[j].start = std::clamp(soil[j], unknowns[j].lower, unknowns[j].upper);
    for (std::size_t i = 0; i < values.size(); ++i) started[soil_count + i].start = values[i];
    return started;
  };
  // Look from every start, then go on from the best.
  struct Look {
    double cost;
    std::vector<Unknown> start;
  };
  std::vector<Look> looks;
  for (const auto& values : starts)
    for (const auto& soil : soils) {
      Look look{0.0, with_start(values, soil)};
      if (!refit) {
        std::vector<double> x, residuals;
        for (const Unknown& u : look.start) x.push_back(std::clamp(u.start, u.lower, u.upper));
        if (!function(x, residuals)) continue;
        for (const double r : residuals) look.cost += r * r;
      }
      looks.push_back(std::move(look));
    }
  std::stable_sort(looks.begin(), looks.end(), [](const Look& a, const Look& b) { return a.cost < b.cost; });
  if (looks.size() > looks_kept) looks.resize(looks_kept);
  FitResult best;
  for (const Look& look : looks) {
    displacements.clear();
    FitResult fit = least_squares(look.start, function, iterations);
    if (fit.usable && fit.cost < best.cost) best = std::move(fit);
  }

  SteadyFit result;
  Candidate& c = result.candidate;
  c.effects = names;
  c.usable = best.usable;
  if (!best.usable) return result;
  const auto error = [&](std::size_t i) {
    return std::sqrt(best.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)));
  };
  result.soil.assign(best.x.begin(), best.x.begin() + static_cast<std::ptrdiff_t>(soil_count));
  for (std::size_t j = 0; j < soil_count; ++j) result.soil_error.push_back(error(j));
  result.baseline = with_soil(evidence, best.x);
  c.values = layout.split(best.x, soil_count);
  c.model = with_effects(result.baseline, layout, c.values);
  std::size_t at = soil_count;
  for (const auto* type : layout.types) {
    c.errors.emplace_back();
    for (std::size_t i = 0; i < type->parameters.size(); ++i) c.errors.back().push_back(error(at++));
    c.parameters += static_cast<int>(type->parameters.size());
  }
  std::vector<double> whitened;
  std::vector<std::size_t> run_of;
  try {
    whiten_means(runs, residuals_of(c.model, result.baseline, runs), evidence.noise, whitened, &run_of);
  } catch (const Error&) {
    c.usable = false;  // a run that its own fit does not carry
    return result;
  }
  c.run_chi_square.assign(runs.size(), 0.0);
  for (std::size_t i = 0; i < whitened.size(); ++i) c.run_chi_square[run_of[i]] += whitened[i] * whitened[i];
  for (const double v : c.run_chi_square) c.chi_square += v;
  return result;
}

std::vector<SteadyRuns> parts_of(const SteadyRuns& runs, std::size_t most) {
  std::map<std::string, SteadyRuns> groups;
  for (const SteadyRun* run : runs) groups[run->group()].push_back(run);
  std::vector<SteadyRuns> parts;
  if (groups.size() < 2) {
    for (const SteadyRun* run : runs) parts.push_back({run});
  } else {
    for (auto& [name, members] : groups) {
      if (!name.empty()) {
        parts.push_back(members);
        continue;
      }
      for (const SteadyRun* run : members) parts.push_back({run});
    }
  }
  while (parts.size() > most) {
    std::stable_sort(parts.begin(), parts.end(),
                     [](const SteadyRuns& a, const SteadyRuns& b) { return a.size() > b.size(); });
    const SteadyRuns last = parts.back();
    parts.pop_back();
    parts.back().insert(parts.back().end(), last.begin(), last.end());
  }
  return parts;
}

LeftOut leave_out(const SteadyEvidence& evidence, const SteadyFit& fit,
                  const std::vector<SteadyRuns>& parts) {
  constexpr int iterations = 20;
  constexpr double share = 0.7;
  // Begins part of the way back to the priors: a fit that cannot move must not keep what it learnt of the
  // part.
  SteadyFit begin = fit;
  for (std::size_t j = 0; j < begin.soil.size(); ++j)
    begin.soil[j] = share * fit.soil[j] + (1.0 - share) * evidence.unknowns[j].prior;
  for (std::size_t k = 0; k < begin.candidate.values.size(); ++k) {
    const auto& parameters = effects::find_effect(fit.candidate.effects[k]).parameters;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const double centre = std::isnan(parameters[i].neutral) || parameters[i].neutral >= parameters[i].upper
                                ? parameters[i].scale
                                : parameters[i].neutral;
      double& value = begin.candidate.values[k][i];
      value = std::clamp(share * value + (1.0 - share) * centre, parameters[i].lower, parameters[i].upper);
    }
  }
  LeftOut result;
  for (const SteadyRuns& part : parts) {
    SteadyRuns others;
    for (const SteadyRuns& other : parts)
      if (&other != &part) others.insert(others.end(), other.begin(), other.end());
    const SteadyFit without = fit_steady(evidence, fit.candidate.effects, others, &begin, iterations);
    if (!without.candidate.usable) return {};
    try {
      const Means residuals = residuals_of(without.candidate.model, without.baseline, part);
      result.runs.insert(result.runs.end(), part.begin(), part.end());
      result.residuals.insert(result.residuals.end(), residuals.begin(), residuals.end());
    } catch (const Error&) {
      return {};
    }
  }
  std::vector<double> whitened;
  whiten_means(result.runs, result.residuals, evidence.noise, whitened);
  for (const double v : whitened) result.chi_square += v * v;
  return result;
}

double certify_left_out(const SteadyEvidence& evidence, const LeftOut& without, const LeftOut& with) {
  if (without.runs.empty() || with.runs != without.runs) return 1.0;
  std::vector<double> a, b;
  whiten_means(without.runs, without.residuals, evidence.noise, a);
  whiten_means(with.runs, with.residuals, evidence.noise, b);
  std::vector<double> votes;
  double along = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    votes.push_back(a[i] * (a[i] - b[i]));
    along += votes.back();
  }
  if (along <= 0.0) return 1.0;
  Random random(2, 0);
  int as_far = 1;
  for (int draw = 0; draw < sign_flips; ++draw) {
    double flipped = 0.0;
    for (const double vote : votes) flipped += random.uniform() < 0.5 ? vote : -vote;
    if (flipped >= along) ++as_far;
  }
  return as_far / (1.0 + sign_flips);
}

}  // namespace wheel_twin::twin
