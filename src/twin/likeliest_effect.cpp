#include "twin/likeliest_effect.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "effects/catalogue.h"
#include "twin/candidates.h"

namespace wheel_twin::twin {

std::optional<LikeliestEffect> likeliest_effect(const TwinConfig& twin, const RunGrid& run,
                                                const NoiseModel& band) {
  constexpr std::size_t fitted = 4;
  constexpr double price = 6.0;  // of a parameter, in chi-square
  constexpr double enough = 0.5;
  Evidence evidence;
  evidence.baseline = twin;
  evidence.noise = {band};
  evidence.runs = {&run};
  evidence.log_deviation.emplace_back();
  evidence.calm.emplace_back();
  evidence.lag.emplace_back();
  const std::vector<std::size_t> all = {0};
  const std::vector<double> residuals = run_residuals(evidence, 0, twin, false);
  double before = 0.0;
  for (const double r : residuals) before += r * r;
  const double excess = before - static_cast<double>(residuals.size());
  if (excess <= 0.0) return std::nullopt;

  std::vector<std::pair<double, const effects::EffectType*>> looks;
  for (const effects::EffectType& type : effects::catalogue()) {
    TwinConfig with = twin;
    with.effects = {{type.name, {}}};
    for (const effects::Parameter& p : type.parameters) with.effects[0].values.push_back(p.scale);
    if (sticks(with)) continue;
    looks.emplace_back(
        foretold_chi_square(evidence, {type.name}, all) + price * static_cast<double>(type.parameters.size()),
        &type);
  }
  std::sort(looks.begin(), looks.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  looks.resize(std::min(looks.size(), fitted));
  double least = before;
  std::optional<LikeliestEffect> best;
  for (const auto& [foretold, type] : looks) {
    const Candidate fit = fit_candidate(evidence, {type->name}, all, {}, 6);
    const double cost = fit.chi_square + price * fit.parameters;
    if (!fit.usable || cost >= least) continue;
    least = cost;
    best = {type->name, std::clamp((before - fit.chi_square) / excess, 0.0, 1.0)};
  }
  if (best && best->explained < enough) return std::nullopt;
  return best;
}

}  // namespace wheel_twin::twin
