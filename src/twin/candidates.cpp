#include "twin/candidates.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "effects/catalogue.h"

namespace wheel_twin::twin {
namespace {

constexpr double log_deviation_error = 0.4;  // of a stretch: few independent values, and what the twin misses
constexpr double prior_widths = 3.0;         // of a parameter's scale
/// Of a parameter that is read from the fluctuation: how far one realisation of an uneven bed is from
/// another.
constexpr double bed_to_bed = 0.15;

/// Values of several effects one after another.
struct Layout {
  std::vector<const effects::EffectType*> types;
  std::size_t nuisance = 0;

  explicit Layout(const std::vector<std::string>& names, std::size_t nuisance_count)
      : nuisance(nuisance_count) {
    for (const std::string& name : names) types.push_back(&effects::find_effect(name));
  }
  std::vector<std::vector<double>> split(const std::vector<double>& x) const {
    std::vector<std::vector<double>> values;
    std::size_t at = nuisance;
    for (const auto* type : types) {
      values.emplace_back();
      for (const effects::Parameter& p : type->parameters) {
        double v = x[at++];
        if (p.periodic)
          v = p.lower +
              std::fmod(std::fmod(v - p.lower, p.upper - p.lower) + (p.upper - p.lower), p.upper - p.lower);
        values.back().push_back(std::clamp(v, p.lower, p.upper));
      }
    }
    return values;
  }
};

TwinConfig model_of(const Evidence& evidence, const Layout& layout, const std::vector<double>& x) {
  TwinConfig model =
      evidence.nuisance.empty()
          ? evidence.baseline
          : with_baseline(evidence.baseline, evidence.nuisance,
                          {x.begin(), x.begin() + static_cast<std::ptrdiff_t>(layout.nuisance)});
  const auto values = layout.split(x);
  for (std::size_t k = 0; k < layout.types.size(); ++k)
    model.effects.push_back({layout.types[k]->name, values[k]});
  return model;
}

using Starts = std::vector<std::vector<double>>;

/// Every start with every choice of the next values behind it.
Starts followed_by(const Starts& starts, const Starts& choices) {
  Starts longer;
  for (const auto& start : starts)
    for (const auto& choice : choices) {
      longer.push_back(start);
      longer.back().insert(longer.back().end(), choice.begin(), choice.end());
    }
  return longer;
}

/// A time or a place: what it does is no smooth function of it, so that it is searched, not derived.
bool is_searched(const effects::Parameter& p) {
  return std::isnan(p.neutral) &&
         ((p.unit == "m" && p.name == "position") || (p.unit == "s" && p.name == "time"));
}

/// Where a fit of one effect begins: strengths to either side of neutral, and shape parameters on a grid. The
/// first is strong enough to show whether the effect changes how much channels fluctuate.
Starts starts_of(const effects::EffectType& type, const Evidence& evidence) {
  Starts starts = {{}};
  bool first_strength = true;
  for (const effects::Parameter& p : type.parameters) {
    std::vector<double> choices;
    if (!std::isnan(p.neutral)) {
      if (p.neutral >= p.upper) {  // a depth: the shallower, the stronger
        choices = {p.lower + 0.2 * p.scale, p.lower + p.scale};
      } else if (type.parameters.size() == 1 && p.neutral <= p.lower) {
        for (const double size : {1.0, 0.15, 0.3, 0.5, 0.7, 1.5, 3.0})
          choices.push_back(p.neutral + size * p.scale);
      } else if (type.parameters.size() == 1) {
        for (const double size : {0.3, 1.0, 3.0})
          for (const double sign : {1.0, -1.0}) {
            const double v = p.neutral + sign * size * p.scale;
            if (v >= p.lower && v <= p.upper) choices.push_back(v);
          }
      } else {
        choices = {std::min(p.upper, p.neutral + (first_strength ? 0.7 : 0.2) * p.scale)};
      }
      first_strength = false;
    } else if (p.periodic) {
      for (int k = 0; k < 4; ++k) choices.push_back(p.lower + (k + 0.5) / 4.0 * (p.upper - p.lower));
    } else if (p.unit == "m" && p.name == "position") {
      double furthest = 0.0;
      for (const RunGrid* run : evidence.runs)
        for (const auto& m : run->motion) furthest = std::max(furthest, m.carriage_position);
      for (int k = 0; k < 14; ++k) choices.push_back(furthest * (k + 0.5) / 14.0);
    } else if (p.unit == "s" && p.name == "time") {
      double last = 0.0;
      for (const RunGrid* run : evidence.runs) last = std::max(last, run->motion.back().time);
      for (int k = 0; k < 14; ++k) choices.push_back(last * (k + 0.5) / 14.0);
    } else {
      choices = {std::clamp(p.scale, p.lower, p.upper)};
    }
    Starts next;
    for (const double choice : choices) next.push_back({choice});
    starts = followed_by(starts, next);
  }
  return starts;
}

/// Whether a candidate at its start changes the deviation of some channel by a tenth.
bool changes_fluctuation(const Evidence& evidence, const Layout& layout,
                         const std::vector<Unknown>& unknowns) {
  if (!evidence.fluctuation.known || evidence.runs.empty()) return false;
  std::vector<double> x;
  for (const Unknown& u : unknowns) x.push_back(u.start);
  try {
    const RunGrid& run = *evidence.runs[evidence.runs.size() / 2];
    const LogDeviation with =
        predicted_log_deviation(model_of(evidence, layout, x), run, evidence.fluctuation);
    const LogDeviation without = predicted_log_deviation(evidence.baseline, run, evidence.fluctuation);
    for (std::size_t c = 0; c < channel_count; ++c)
      if (std::abs(with[c] - without[c]) > 0.1) return true;
  } catch (const Error&) {
  }
  return false;
}

}  // namespace

std::vector<double> run_residuals(const Evidence& evidence, std::size_t run, const TwinConfig& model,
                                  bool with_fluctuation, std::vector<int>* block, const LogDeviation* held) {
  const RunGrid& grid = *evidence.runs[run];
  std::vector<double> out;
  LogDeviation predicted{};
  Predicted course;
  if (with_fluctuation && evidence.fluctuation.known) {
    const Fluctuating simulated = simulate_fluctuating(model, grid, evidence.fluctuation_of(run));
    predicted = simulated.log_deviation;
    course = simulated.course;
  } else {
    course = simulate(model, grid);
    predicted = held != nullptr ? *held : evidence.calm[run];
  }
  int next = whiten(grid, residual_of(grid, course), evidence.noise[run], out, block);
  if (evidence.fluctuation.known)
    for (const LogDeviation& measured : evidence.log_deviation[run]) {
      for (std::size_t c = 0; c < channel_count; ++c) {
        if (!std::isfinite(measured[c]) || !std::isfinite(predicted[c])) continue;
        out.push_back(std::clamp((measured[c] - predicted[c]) / log_deviation_error, -12.0, 12.0));
        if (block != nullptr) block->push_back(next);
      }
      ++next;
    }
  for (const double lag : evidence.lag[run]) {
    out.push_back((lag - draw_wire_delay(model)) / evidence.lag_error);
    if (block != nullptr) block->push_back(next);
    ++next;
  }
  if (run < evidence.zero.size() && std::isfinite(evidence.zero[run])) {
    const double off = (evidence.zero[run] - zero_of(model, grid)) / evidence.zero_error;
    out.push_back(std::clamp(off, -12.0, 12.0));
    if (block != nullptr) block->push_back(next);
  }
  return out;
}

double zero_of(const TwinConfig& model, const RunGrid& run) {
  rig::RigState state;
  state.wheel_angle = run.motion.front().wheel_angle;
  const Acting acting = acting_effects(model);
  double displacement = -rig::hub_rise(acting.ports, state);
  for (const rig::SensorPort* port : acting.ports.sensor) port->change_displacement(state, 0.0, displacement);
  return displacement - rig::draw_wire_delay(acting.ports) * (run.touch ? run.touch->speed : 0.0);
}

double draw_wire_delay(const TwinConfig& model) {
  const Acting acting = acting_effects(model);
  return rig::draw_wire_delay(acting.ports);
}

std::vector<double> chi_squares(const Evidence& evidence, const TwinConfig& model,
                                const std::vector<std::size_t>& runs, bool with_fluctuation) {
  std::vector<double> sums;
  for (const std::size_t run : runs) {
    double sum = 0.0;
    for (const double r : run_residuals(evidence, run, model, with_fluctuation)) sum += r * r;
    sums.push_back(sum);
  }
  return sums;
}

namespace {

/// Everything a fit needs to know before it starts.
struct Problem {
  const Evidence& evidence;
  const std::vector<std::size_t>& runs;
  Layout layout;
  std::vector<Unknown> unknowns;
  Starts starts;               // of the effects' parameters
  std::vector<bool> searched;  // of all unknowns

  Problem(const Evidence& e, const std::vector<std::string>& names, const std::vector<std::size_t>& chosen,
          const std::vector<std::vector<double>>& known)
      : evidence(e), runs(chosen), layout(names, e.nuisance.size()), unknowns(e.nuisance) {
    for (const auto* type : layout.types)
      for (const effects::Parameter& p : type->parameters) unknowns.push_back(unknown_of(*type, p));
    searched.assign(e.nuisance.size(), false);
    for (const auto* type : layout.types)
      for (const effects::Parameter& p : type->parameters) searched.push_back(is_searched(p));
    std::vector<double> prefix;
    for (const auto& values : known) prefix.insert(prefix.end(), values.begin(), values.end());
    starts = {prefix};
    for (std::size_t k = known.size(); k < layout.types.size(); ++k)
      starts = followed_by(starts, starts_of(*layout.types[k], evidence));
  }

  static Unknown unknown_of(const effects::EffectType& type, const effects::Parameter& p) {
    Unknown u;
    u.name = p.name;
    u.lower = p.periodic ? -1e9 : p.lower;
    u.upper = p.periodic ? 1e9 : p.upper;
    u.scale = p.scale;
    if (!std::isnan(p.neutral)) {
      u.prior = p.neutral;
      u.prior_deviation = prior_widths * p.scale;
    }
    if (type.name == "hard_layer") u.prior_deviation = 1e9;  // its neutral is far from any depth that matters
    return u;
  }

  std::vector<Unknown> started(const std::vector<double>& effect_values) const {
    std::vector<Unknown> result = unknowns;
    for (std::size_t i = 0; i < effect_values.size(); ++i)
      result[evidence.nuisance.size() + i].start = effect_values[i];
    return result;
  }

  /// Residuals of all runs; false when x cannot be simulated.
  bool residuals(const std::vector<double>& x, bool with_fluctuation, const std::vector<LogDeviation>& held,
                 std::vector<double>& out) const {
    try {
      const TwinConfig model = model_of(evidence, layout, x);
      for (std::size_t k = 0; k < runs.size(); ++k) {
        const std::vector<double> r = run_residuals(evidence, runs[k], model, with_fluctuation, nullptr,
                                                    held.empty() ? nullptr : &held[k]);
        out.insert(out.end(), r.begin(), r.end());
      }
    } catch (const Error&) {
      return false;
    }
    return true;
  }
};

std::vector<double> values_of(const std::vector<Unknown>& unknowns) {
  std::vector<double> x;
  for (const Unknown& u : unknowns) x.push_back(u.start);
  return x;
}

double square_sum(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return sum;
}

}  // namespace

namespace {

/// Where one Gauss-Newton step from a start leads.
struct Look {
  double foretold = std::numeric_limits<double>::infinity();  // chi-square there, were the residual linear
  std::vector<double> x;
  Eigen::MatrixXd jacobian;  // by the unknowns in units of their scales
};

Look look_from(const Problem& problem, const std::vector<double>& start) {
  constexpr double difference = 0.02;  // of the scale
  const std::vector<Unknown> unknowns = problem.started(start);
  Look look;
  look.x = values_of(unknowns);
  std::vector<double> here;
  if (!problem.residuals(look.x, false, {}, here)) return look;
  const auto rows = static_cast<Eigen::Index>(here.size()),
             columns = static_cast<Eigen::Index>(look.x.size());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(rows, columns);
  const Eigen::MatrixXd& known = problem.evidence.nuisance_columns;
  const bool reuse = known.rows() == rows && known.cols() > 0;
  if (reuse) jacobian.leftCols(known.cols()) = known;
  for (Eigen::Index j = reuse ? known.cols() : 0; j < columns; ++j) {
    const auto k = static_cast<std::size_t>(j);
    if (problem.searched[k]) continue;
    std::vector<double> near = look.x, there;
    near[k] += (near[k] + difference * unknowns[k].scale > unknowns[k].upper ? -1.0 : 1.0) * difference *
               unknowns[k].scale;
    if (!problem.residuals(near, false, {}, there)) continue;
    for (Eigen::Index i = 0; i < rows; ++i)
      jacobian(i, j) = (there[static_cast<std::size_t>(i)] - here[static_cast<std::size_t>(i)]) /
                       (near[k] - look.x[k]) * unknowns[k].scale;
  }
  const Eigen::Map<const Eigen::VectorXd> r(here.data(), rows);
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  information.diagonal().array() += 1e-3 + 1e-9 * information.diagonal().maxCoeff();
  const Eigen::VectorXd slope = jacobian.transpose() * r;
  const Eigen::VectorXd step = information.ldlt().solve(slope);
  look.foretold = r.squaredNorm() - slope.dot(step);
  for (Eigen::Index j = 0; j < columns; ++j) {
    const auto k = static_cast<std::size_t>(j);
    look.x[k] = std::clamp(look.x[k] - step[j] * unknowns[k].scale, unknowns[k].lower, unknowns[k].upper);
  }
  look.jacobian = std::move(jacobian);
  return look;
}

/// A start moved along the times and places that are searched, by half the distance between two starts, a
/// quarter, and so on, to where a look promises most.
std::vector<double> searched_from(const Problem& problem, std::vector<double> start) {
  constexpr int halvings = 5;
  const std::size_t before = problem.evidence.nuisance.size();
  for (std::size_t k = 0; k < start.size(); ++k) {
    if (!problem.searched[before + k]) continue;
    double distance = std::numeric_limits<double>::infinity();  // to the next start
    for (const auto& other : problem.starts)
      if (other[k] != start[k]) distance = std::min(distance, std::abs(other[k] - start[k]));
    if (!std::isfinite(distance)) continue;
    double best = look_from(problem, start).foretold;
    for (int i = 0; i < halvings; ++i) {
      distance *= 0.5;
      const double middle = start[k];
      for (const double value : {middle - distance, middle + distance}) {
        std::vector<double> moved = start;
        moved[k] = std::clamp(value, problem.unknowns[before + k].lower, problem.unknowns[before + k].upper);
        const double foretold = look_from(problem, moved).foretold;
        if (foretold < best) best = foretold, start = moved;
      }
    }
  }
  return start;
}

/// Starts of friction of every size with the effects beside it where a fit without it puts them: friction
/// holds the hub wherever a fit begins, and what it was found to be beside one effect it is not beside
/// another. Empty where there is no friction, or nothing beside it that is not known.
Starts starts_beside_friction(const Problem& problem, const std::vector<std::string>& names,
                              const std::vector<std::vector<double>>& known, int iterations) {
  const std::vector<std::vector<double>> first =
      problem.layout.split(values_of(problem.started(problem.starts.front())));
  std::vector<std::string> beside;
  std::vector<std::vector<double>> known_beside;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (is_friction({names[k], first[k]})) continue;
    beside.push_back(names[k]);
    if (k < known.size()) known_beside.push_back(known[k]);
  }
  if (beside.empty() || beside.size() == names.size() || known_beside.size() == beside.size()) return {};
  const Candidate without = fit_candidate(problem.evidence, beside, problem.runs, known_beside, iterations);
  if (!without.usable) return {};
  Starts starts = {{}};
  for (std::size_t k = 0, found = 0; k < names.size(); ++k) {
    const bool is_beside = found < beside.size() && beside[found] == names[k];
    const auto choices =
        is_beside ? Starts{without.values[found++]} : starts_of(*problem.layout.types[k], problem.evidence);
    starts = followed_by(starts, choices);
  }
  return starts;
}

}  // namespace

double foretold_chi_square(const Evidence& evidence, const std::vector<std::string>& names,
                           const std::vector<std::size_t>& runs,
                           const std::vector<std::vector<double>>& known) {
  // Friction that is already known holds whatever is added to it alike, and is left out of the look.
  std::vector<std::string> looked_at;
  std::vector<std::vector<double>> values;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (k < known.size() && is_friction({names[k], known[k]})) continue;
    looked_at.push_back(names[k]);
    if (k < known.size()) values.push_back(known[k]);
  }
  const Problem problem(evidence, looked_at, runs, values);
  if (sticks(model_of(evidence, problem.layout, values_of(problem.started(problem.starts.front())))))
    return 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& start : problem.starts) least = std::min(least, look_from(problem, start).foretold);
  return least;
}

void begin_nuisance_at(Evidence& evidence, const Candidate& nothing) {
  if (evidence.nuisance.empty()) return;
  for (std::size_t i = 0; i < evidence.nuisance.size(); ++i) evidence.nuisance[i].start = nothing.nuisance[i];
  std::vector<std::size_t> runs(evidence.runs.size());
  std::iota(runs.begin(), runs.end(), std::size_t{0});
  const Problem problem(evidence, {}, runs, {});
  evidence.nuisance_columns = look_from(problem, {}).jacobian;
}

Candidate fit_candidate(const Evidence& evidence, const std::vector<std::string>& names,
                        const std::vector<std::size_t>& runs, const std::vector<std::vector<double>>& known,
                        int iterations) {
  Problem problem(evidence, names, runs, known);
  const Layout& layout = problem.layout;
  // Only some causes change how much the channels fluctuate; the others are fitted without that question.
  // Those that work through friction are asked at every step, for the others the answer at the start holds.
  const bool fluctuates = changes_fluctuation(evidence, layout, problem.started(problem.starts.front()));
  std::vector<LogDeviation> held;
  bool in_loop = false;
  const ResidualFunction function = [&](const std::vector<double>& x, std::vector<double>& out) {
    return problem.residuals(x, in_loop, held, out);
  };
  // Friction holds the hub where a fit puts it: what acts beside it begins where it is without friction, too.
  if (fluctuates && names.size() > 1)
    for (const auto& start : starts_beside_friction(problem, names, known, iterations))
      problem.starts.push_back(start);
  // A step from every start, then on from the two that lead furthest.
  std::vector<std::vector<Unknown>> begins;
  if (problem.starts.size() == 1) {
    begins.push_back(problem.started(problem.starts.front()));
  } else {
    // Friction shows in the fluctuation only, which a step does not ask for: there the starts are compared.
    const bool by_friction =
        fluctuates && sticks(model_of(evidence, layout, values_of(problem.started(problem.starts.front()))));
    std::vector<std::pair<Look, std::size_t>> looks;
    for (std::size_t s = 0; s < problem.starts.size(); ++s) {
      if (!by_friction) {
        looks.emplace_back(look_from(problem, problem.starts[s]), s);
        continue;
      }
      Look look;
      look.x = values_of(problem.started(problem.starts[s]));
      std::vector<double> residuals;
      if (problem.residuals(look.x, true, {}, residuals)) look.foretold = square_sum(residuals);
      looks.emplace_back(look, s);
    }
    std::stable_sort(looks.begin(), looks.end(),
                     [](const auto& a, const auto& b) { return a.first.foretold < b.first.foretold; });
    looks.resize(2);
    for (const auto& [look, s] : looks) {
      if (!std::isfinite(look.foretold)) continue;
      const std::vector<double> start =
          by_friction ? problem.starts[s] : searched_from(problem, problem.starts[s]);
      const Look closer = start == problem.starts[s] ? look : look_from(problem, start);
      std::vector<Unknown> begin = problem.started(start);
      std::vector<double> before, after;
      problem.residuals(values_of(begin), false, {}, before);
      if (!by_friction && problem.residuals(closer.x, false, {}, after) &&
          square_sum(after) < square_sum(before))
        for (std::size_t i = 0; i < begin.size(); ++i) begin[i].start = closer.x[i];
      begins.push_back(begin);
    }
  }
  FitResult best;
  for (const std::vector<Unknown>& unknowns : begins) {
    held.clear();
    if (fluctuates) {
      try {
        const TwinConfig model = model_of(evidence, layout, values_of(unknowns));
        in_loop = sticks(model);
        if (!in_loop)
          for (const std::size_t run : runs)
            held.push_back(predicted_log_deviation(model, *evidence.runs[run], evidence.fluctuation_of(run)));
      } catch (const Error&) {
        continue;
      }
    }
    FitResult fit = least_squares(unknowns, function, iterations);
    if (fit.usable && fit.cost < best.cost) best = std::move(fit);
  }

  Candidate candidate;
  candidate.effects = names;
  candidate.usable = best.usable;
  if (!best.usable) return candidate;
  candidate.model = model_of(evidence, layout, best.x);
  candidate.values = layout.split(best.x);
  candidate.nuisance.assign(best.x.begin(),
                            best.x.begin() + static_cast<std::ptrdiff_t>(evidence.nuisance.size()));
  std::size_t at = evidence.nuisance.size();
  for (const auto* type : layout.types) {
    candidate.errors.emplace_back();
    const bool by_fluctuation = fluctuates && sticks(candidate.model);
    for (std::size_t i = 0; i < type->parameters.size(); ++i, ++at) {
      double error =
          std::hypot(std::sqrt(best.covariance(static_cast<Eigen::Index>(at), static_cast<Eigen::Index>(at))),
                     by_fluctuation ? bed_to_bed * best.x[at] : 0.0);
      // The bin in which something happens is certain, its place within the bin hardly.
      const double bin = evidence.runs.front()->bin;
      if (problem.searched[at] && type->parameters[i].unit == "s")
        error = std::clamp(error, bin / std::sqrt(12.0), bin);
      candidate.errors.back().push_back(error);
      const double prior = problem.unknowns[at].prior_deviation;
      candidate.told += std::max(0.0, 1.0 - error * error / (prior * prior));
    }
    candidate.parameters += static_cast<int>(type->parameters.size());
  }
  candidate.fluctuates = fluctuates;
  candidate.run_chi_square = chi_squares(evidence, candidate.model, runs, fluctuates);
  for (const double c : candidate.run_chi_square) candidate.chi_square += c;
  return candidate;
}

}  // namespace wheel_twin::twin
