// Runs of which only window means are known: each is one operating point (slip, load, steering angle) with
// one number a channel. Nothing has a course in time here; what a perfect twin would still show is how much
// repeated runs differ, within one group (day, filling, tare) and between groups.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "twin/run_grid.h"
#include "twin/simulate.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

/// One operating point. `grid` has two bins, the start of the run and the centre of its window, between which
/// the wheel rolls at the declared speeds, and one window per measured channel. The load that was read leads
/// the twin, where there is one: its normal_load window then holds the reading to account for.
struct SteadyRun {
  RunGrid grid;
  bool reference = false;  ///< effects do not act in it

  const std::string& group() const { return grid.declared.group; }
};

/// The load under which the twin of a run stands: the mean that was read, else the declared one, N.
double leading_load(const logs::Run& run);

/// The steering angle at which it stands: a hundredth of a degree is an encoder's zero, not a steered wheel,
/// of which the contact would press the whole side wall of a locked wheel, rad.
double leading_steering(const logs::Run& run);

/// True when the measured runs have window means of forces or displacement and no force over time.
bool known_by_means(const std::vector<RunGrid>& grids);

/// Throws Error naming the run when it has no averages.
SteadyRun steady_run(const logs::Run& run, const std::string& name, double radius);

/// Scatter of one channel between runs that a perfect twin would still show, and what a good contact law may
/// miss besides.
struct SteadyScatter {
  double within = 0.0;     ///< between runs of one group, SI
  double between = 0.0;    ///< between groups, SI
  double tolerance = 0.0;  ///< of the contact law, run by run: 2 % of the load, or of the deepest sinkage
  int pairs = 0;           ///< of repeated runs that tell the scatter; 0: assumed

  double total() const;        ///< the noise floor: without the tolerance
  double independent() const;  ///< of one run of a group: with the tolerance
};
using SteadyNoise = std::array<SteadyScatter, channel_count>;

/// From runs that repeat one condition (slip to 0.02, steering angle to 1 degree, load to 2 %); where there
/// are none, the scatter of the window and 2 % of the load.
SteadyNoise steady_noise(const logs::Experiment& experiment, const std::vector<SteadyRun>& runs);

/// Twin's value of every window of a run. Throws Error when soil and wheel cannot carry the load.
/// `displacement`: a guess of the true hub displacement (m; not above 0: none), which is set to the one
/// found.
std::vector<double> predict_means(const TwinConfig& model, const SteadyRun& run,
                                  double* displacement = nullptr);

/// Measured less predicted of several runs, each in the order of its windows.
using Means = std::vector<std::vector<double>>;
Means residuals_of(const TwinConfig& model, const TwinConfig& reference_model,
                   const std::vector<const SteadyRun*>& runs);
/// The same for a fit, which must go on where the soil does not carry a run: the wheel is down to its hub and
/// pulls nothing there. `displacements`: guesses of predict_means, by run; false when no run is carried.
bool residuals_for_fit(const TwinConfig& model, const TwinConfig& reference_model,
                       const std::vector<const SteadyRun*>& runs, std::vector<double>& displacements,
                       Means& residuals);

/// Appends residuals over their scatter, so that those of one group become independent: what the runs of a
/// group have in common counts once. `block` receives the index of the run of each value.
void whiten_means(const std::vector<const SteadyRun*>& runs, const Means& residuals, const SteadyNoise& noise,
                  std::vector<double>& out, std::vector<std::size_t>* run_of = nullptr);

}  // namespace wheel_twin::twin
