// Small statistics of sampled channels, for judging a log.
#pragma once

#include <cstddef>
#include <vector>

namespace wheel_twin::logs {

double median(std::vector<double> values);  ///< NaN for none
double quantile(std::vector<double> values,
                double fraction);  ///< nearest rank, fraction 0 to 1; NaN for none

/// Samples in a row with exactly the same value.
struct EqualRun {
  std::size_t begin = 0;
  std::size_t length = 0;
};
std::vector<EqualRun> equal_runs(const std::vector<double>& values);

/// Length of the run in which a sample stands, for the sample at `fraction` of all samples sorted by it. 0
/// for no run.
double run_length_quantile(const std::vector<EqualRun>& runs, double fraction);

struct Line {
  double slope = 0.0;
  double offset = 0.0;
};
Line fit_line(const std::vector<double>& x,
              const std::vector<double>& y);  ///< least squares; at least 2 points

/// Equally spaced values less their straight line; at least 2.
std::vector<double> without_line(std::vector<double> values);

/// `y` at `at`, linear between the samples of increasing `x`, constant outside. At least one sample.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at);

}  // namespace wheel_twin::logs
