#include "twin/tracing.h"

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "base/progress.h"
#include "effects/catalogue.h"
#include "twin/parallel.h"

namespace wheel_twin::twin {
namespace {

constexpr std::size_t fitted_singles = 14, fitted_pairs = 7;  // of those that promise most

}  // namespace

Tracing::Tracing(const Evidence& evidence, int threads) : evidence_(evidence), threads_(threads) {
  runs_.resize(evidence.runs.size());
  std::iota(runs_.begin(), runs_.end(), std::size_t{0});
  double blocks = 0.0;
  for (const RunGrid* run : evidence.runs) blocks += run->bins() * run->bin / 6.0;
  price_ = 0.5 * std::log(std::max(3.0, blocks));
}

Candidate Tracing::nothing() const {
  return scored(fit_candidate(evidence_, {}, runs_));
}

std::vector<Candidate> Tracing::every_effect(const Candidate& base) const {
  const Evidence& evidence = evidence_of(base, evidence_);
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
  in_parallel(names.size(), threads_, [&](std::size_t i) {
    foretold[i] = foretold_chi_square(evidence, with(names[i]), runs_, base.values);
    progress.update(0.5 * ++done);
  });
  std::vector<std::size_t> order(names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return foretold[a] < foretold[b]; });
  order.resize(std::min(order.size(), base.effects.empty() ? fitted_singles : fitted_pairs));
  std::vector<Candidate> candidates(order.size());
  in_parallel(order.size(), threads_, [&](std::size_t i) {
    candidates[i] = scored(fit_candidate(evidence, with(names[order[i]]), runs_, base.values));
    candidates[i].own = base.own;
    progress.update(0.5 * (done += 1));
  });
  candidates.erase(
      std::remove_if(candidates.begin(), candidates.end(), [](const Candidate& c) { return !c.usable; }),
      candidates.end());
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  return candidates;
}

void Tracing::judge_again(Candidate& candidate) const {
  candidate.run_chi_square = chi_squares(evidence_, candidate.model, runs_, candidate.fluctuates);
  candidate.chi_square =
      std::accumulate(candidate.run_chi_square.begin(), candidate.run_chi_square.end(), 0.0);
}

Candidate Tracing::scored(Candidate candidate) const {
  double chi_square = candidate.chi_square, volume = 0.0;
  const Doubt& doubt = candidate.doubt;
  if (doubt.slope.size() > 0) {
    // Over soils: r^T (1 + D D^T)^-1 r + ln det (1 + D^T D) instead of r^T r, and cooled as that is.
    const Eigen::LDLT<Eigen::MatrixXd> solver(
        Eigen::MatrixXd::Identity(doubt.slope.size(), doubt.slope.size()) + doubt.information);
    chi_square -= doubt.slope.dot(solver.solve(doubt.slope));
    volume = solver.vectorD().array().log().sum();
  }
  candidate.score = -0.5 * chi_square / temperature_ - 0.5 * volume - price_ * candidate.told;
  return candidate;
}

void Tracing::set_temperature(const Candidate& best) {
  temperature_ = std::max(3.0, 3.0 * best.chi_square / std::max(1.0, count()));
}

double Tracing::count() const {
  double sum = 0.0;
  for (std::size_t r = 0; r < evidence_.runs.size(); ++r)
    sum += static_cast<double>(run_residuals(evidence_, r, evidence_.baseline, false).size());
  return sum;
}

}  // namespace wheel_twin::twin
