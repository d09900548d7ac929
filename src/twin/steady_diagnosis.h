// The diagnosis of an experiment whose forces are known by window means only (real logs with holes): the soil
// is fitted together with the effects, what is claimed is scored on groups (days) left out, and the stages
// that need a course over time step aside.
#pragma once

#include "logs/experiment.h"
#include "twin/diagnosis.h"

namespace wheel_twin::twin {

/// Completes `d`, in which the grids of all runs stand. Steered runs stay out where straight ones are enough.
/// Throws Error when there are too few runs, or none that soil and wheel can carry.
void diagnose_by_means(const logs::Experiment& experiment, const DiagnosisOptions& options, Diagnosis& d);

}  // namespace wheel_twin::twin
