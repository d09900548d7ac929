// How much each channel fluctuates, in log measure and against the twin on an uneven bed. Some causes
// (friction in the guide) leave every mean alone and show in nothing else.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "twin/noise.h"
#include "twin/run_grid.h"
#include "twin/simulate.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

/// Logarithm of the deviation about a slow level, by channel; NaN where it cannot be told.
using LogDeviation = std::array<double, channel_count>;

/// While moving, robust against a few outliers. `rows` are measured or predicted values on the bins of
/// `grid`.
LogDeviation log_deviation(const RunGrid& grid, const Predicted& rows);

/// The same for equal stretches of the run, one after another: independent views of one cause. Four, fewer of
/// a short run.
std::vector<LogDeviation> log_deviation_by_stretch(const RunGrid& grid, const Predicted& rows);

/// Mean over stretches or runs; NaN where none can tell.
LogDeviation mean_of(const std::vector<LogDeviation>& several);

/// A model of a bed's unevenness and of the noise that each channel has besides.
struct FluctuationModel {
  Unevenness unevenness;
  std::array<double, channel_count> other{};  ///< deviation of what unevenness does not make, SI
  LogDeviation beyond{};  ///< what runs at this slip and load fluctuate beyond the model, in log
  bool known = false;     ///< false: nothing is known (no reference runs)
};

/// Sets the unevenness so that the twin's hub fluctuates on the reference runs as the measured one does.
FluctuationModel fit_fluctuation(const TwinConfig& model, const std::vector<const RunGrid*>& references,
                                 const std::vector<Residual>& residuals);

/// What each of `runs` fluctuates beyond the model, in log: what the reference runs nearest in slip and load
/// do.
std::vector<LogDeviation> fluctuation_beyond(const FluctuationModel& fluctuation, const TwinConfig& model,
                                             const std::vector<const RunGrid*>& references,
                                             const std::vector<Residual>& residuals,
                                             const std::vector<const RunGrid*>& runs);

/// Whether one tone, the same in most runs, is most of what a channel fluctuates by: a machine hums, grains
/// and friction do not. Returns its frequency, Hz; nothing where no channel has one.
std::optional<double> common_tone(const std::vector<const RunGrid*>& grids,
                                  const std::vector<Residual>& residuals);

/// Whether an effect holds the slide by friction.
bool is_friction(const EffectSetting& setting);

/// Whether any effect of a twin does.
bool sticks(const TwinConfig& model);

/// A twin less the effects that rub in the guide.
TwinConfig without_friction(TwinConfig model);

/// The course that a twin foretells: on a real bed unevenness works a slide with friction loose, so that its
/// slow course is that of a slide without.
Predicted slow_course(const TwinConfig& model, const RunGrid& grid);

/// A twin on an uneven bed.
struct Fluctuating {
  Predicted course;            ///< slow course, as of slow_course
  LogDeviation log_deviation;  ///< mean of several beds
};
Fluctuating simulate_fluctuating(const TwinConfig& model, const RunGrid& grid,
                                 const FluctuationModel& fluctuation);

/// Log deviation that a twin would log on this run.
LogDeviation predicted_log_deviation(const TwinConfig& model, const RunGrid& grid,
                                     const FluctuationModel& fluctuation);

}  // namespace wheel_twin::twin
