#include "twin/recalibration.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include "base/error.h"

namespace wheel_twin::twin {
namespace {

constexpr int iterations = 30;

/// `run` less what the effects of `model` do to it.
RunGrid freed(const RunGrid& run, const TwinConfig& model) {
  TwinConfig alone = model;
  alone.effects.clear();
  const Predicted done = slow_course(model, run) - slow_course(alone, run);
  RunGrid result = run;
  result.measured -= done;
  for (WindowMean& window : result.windows) window.mean -= window_mean(done, run, window);
  return result;
}

}  // namespace

Recalibration::Recalibration(const TwinConfig& declared, const NoiseFloor& floor, const Evidence& evidence)
    : declared_(declared), floor_(floor), evidence_(evidence) {}

Candidate Recalibration::operator()(const Candidate& candidate) const {
  std::vector<std::size_t> all(evidence_.runs.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  Candidate best = candidate;
  try {
    std::vector<RunGrid> runs;
    for (const RunGrid* run : evidence_.runs) runs.push_back(freed(*run, candidate.model));
    std::vector<const RunGrid*> pointers;
    for (const RunGrid& run : runs) pointers.push_back(&run);
    const Calibration calibration = calibrate(declared_, pointers, floor_);
    const auto own = std::make_shared<Evidence>(evidence_);
    own->baseline = calibration.model;
    own->baseline.corrections.clear();
    own->baseline.table =
        std::make_shared<terramechanics::ContactTable>(own->baseline.wheel, own->baseline.soil);
    own->nuisance = unknowns_beside_shape(calibration);
    own->nuisance_columns.resize(0, 0);
    Candidate again = fit_candidate(*own, candidate.effects, all, candidate.values, iterations);
    again.own = own;
    if (again.usable && again.chi_square < best.chi_square) best = std::move(again);
  } catch (const Error&) {
    // No soil near the declared one carries the runs less this candidate: it stays on the soil it had.
  }
  return best;
}

}  // namespace wheel_twin::twin
