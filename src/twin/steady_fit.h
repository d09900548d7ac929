// Explanations of runs known by means: a soil near the declared one (near the plates' where there are plate
// tests) with effects on top, all fitted at once; and how well each foretells groups that it was not fitted
// to.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "twin/candidates.h"
#include "twin/fit.h"
#include "twin/steady_runs.h"

namespace wheel_twin::twin {

struct SteadyEvidence {
  TwinConfig declared;            ///< with the plates' soil where there are plate tests
  std::vector<Unknown> unknowns;  ///< of the soil, with priors about `declared`
  double reference_depth = 0.02;  ///< at which the unknown pressure and exponent are independent, m
  SteadyNoise noise;
};

using SteadyRuns = std::vector<const SteadyRun*>;

/// Unknowns of the soil: ln of the pressure at `reference_depth`, n, c, phi, ln K, c1, c2.
std::vector<Unknown> soil_unknowns(const terramechanics::Soil& declared, double pressure_deviation,
                                   double exponent_deviation);
TwinConfig with_soil(const SteadyEvidence& evidence, const std::vector<double>& x);

/// A fitted explanation. In `candidate`, chi-squares are by run, in the order of the runs fitted to.
struct SteadyFit {
  Candidate candidate;
  TwinConfig baseline;       ///< the same soil without the effects: reference runs
  std::vector<double> soil;  ///< the unknowns
  std::vector<double> soil_error;
};

/// Looks from several starts, `known` giving those of leading effects, and goes on from the best of them.
SteadyFit fit_steady(const SteadyEvidence& evidence, const std::vector<std::string>& effects,
                     const SteadyRuns& runs, const SteadyFit* known = nullptr, int iterations = 40,
                     std::size_t looks_kept = 2);

/// Runs in parts that are left out together: by group, by turns where there is one group or none. At most
/// `most` parts.
std::vector<SteadyRuns> parts_of(const SteadyRuns& runs, std::size_t most = 8);

/// Every run foretold by a fit to the parts without it. `residuals` in the order of `runs`; empty when some
/// part cannot be foretold at all.
struct LeftOut {
  SteadyRuns runs;
  Means residuals;
  double chi_square = 0.0;
};
LeftOut leave_out(const SteadyEvidence& evidence, const SteadyFit& fit, const std::vector<SteadyRuns>& parts);

/// p-value of "what `with` foretells beyond `without` is chance": sign-flip test on how far the residuals of
/// the groups left out go along with what `with` foretells of them, each run and channel with a sign of its
/// own. Exact for residuals that are symmetric about zero whatever their distribution; a single loud run
/// cannot make it small.
double certify_left_out(const SteadyEvidence& evidence, const LeftOut& without, const LeftOut& with);

}  // namespace wheel_twin::twin
