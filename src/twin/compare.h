// `twin compare`: every run of an experiment beside the twin. Where the experiment has plate tests, the
// soil's k_c, k_phi and n come from them; the rest of wheel and soil is as declared, and nothing of it is
// fitted to runs. An experiment does not declare how the sensor is mounted: where it has reference runs their
// logs tell it (rig/mount_fit.h: linear in what was measured, no soil model).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "logs/experiment.h"
#include "rig/mount_fit.h"
#include "twin/metrics.h"
#include "twin/plate_fit.h"
#include "twin/run_comparison.h"

namespace wheel_twin::twin {

struct ExperimentComparison {
  logs::Experiment experiment;
  terramechanics::Soil soil;  ///< of the twin
  std::vector<PressCurve> press_curves;
  std::optional<PlateFit> plate_fit;
  std::string plate_note;                  ///< why there is no fit where there are plate tests
  rig::RigSettings rig;                    ///< of the twin
  std::optional<rig::MountFit> mount_fit;  ///< none: the mount is that of the rig as given
  std::vector<RunComparison> runs;
};

/// Reads bags one at a time (reference runs once more before). `rig`: its declared description, of which
/// nothing is fitted then; none: a rig with rig::RigSettings' values and the mount of the reference runs.
/// Throws Error naming the file when a bag cannot be read.
ExperimentComparison compare_experiment(const logs::Experiment& experiment,
                                        const ComparisonOptions& options = {},
                                        const std::optional<rig::RigSettings>& rig = std::nullopt);

/// Name by which a run goes in outputs: its bag, or where it has none its group, slip and place in the list.
std::string name_of_run(const logs::Experiment& experiment, std::size_t index);

/// metrics.json, residuals.csv and index.html in `directory`, each whole or not at all.
void write_comparison(const ExperimentComparison& comparison, const std::string& directory);

/// Parts of write_comparison.
std::string metrics_json(const ExperimentComparison& comparison);
std::string residuals_csv(const ExperimentComparison& comparison);
std::string comparison_page(const ExperimentComparison& comparison);

}  // namespace wheel_twin::twin
