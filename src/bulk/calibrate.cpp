#include "bulk/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/random.h"
#include "bulk/angle_of_repose.h"
#include "bulk/direct_shear.h"
#include "bulk/gaussian_process.h"

namespace wheel_twin::bulk {
namespace {

constexpr int grid = 61;

// Parameters in the unit square: friction along the first axis, logarithm of the modulus along the second.
struct Scaling {
  const CalibrationSettings& s;
  Eigen::Vector2d to_unit(const GrainParameters& p) const {
    return {(p.friction - s.lowest_friction) / (s.highest_friction - s.lowest_friction),
            std::log(p.shear_modulus / s.lowest_modulus) / std::log(s.highest_modulus / s.lowest_modulus)};
  }
  GrainParameters from_unit(const Eigen::Vector2d& u) const {
    return {s.lowest_friction + u[0] * (s.highest_friction - s.lowest_friction),
            s.lowest_modulus * std::pow(s.highest_modulus / s.lowest_modulus, u[1])};
  }
};

// Points of the R2 sequence (Roberts, 2018): they fill the square evenly, whatever their number.
Eigen::Vector2d even_point(int index, double shift) {
  constexpr double g = 1.32471795724474602596;
  const double x = shift + (index + 1) / g;
  const double y = shift + (index + 1) / (g * g);
  return {x - std::floor(x), y - std::floor(y)};
}

struct Surface {
  std::vector<std::optional<GaussianProcess>> process;  // one a quantity
};

Surface learn(const Measurements& measured, const std::vector<Evaluation>& evaluations,
              const Scaling& scaling) {
  Surface surface;
  for (std::size_t q = 0; q < quantity_count; ++q) {
    surface.process.emplace_back();
    if (!measured[q]) continue;
    std::vector<Eigen::Vector2d> inputs;
    std::vector<double> values;
    for (const Evaluation& e : evaluations)
      if (std::isfinite(e.value[q])) {
        inputs.push_back(scaling.to_unit(e.at));
        values.push_back(e.value[q]);
      }
    Eigen::MatrixXd x(inputs.size(), 2);
    for (std::size_t i = 0; i < inputs.size(); ++i) x.row(static_cast<Eigen::Index>(i)) = inputs[i];
    surface.process.back().emplace(
        x, Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  }
  return surface;
}

struct Point {
  double log_likelihood = 0.0;
  double doubt = 0.0;  // variance of the surface in units of the measurement's
};

Point judge(const Measurements& measured, const Surface& surface, const Eigen::Vector2d& u) {
  Point point;
  for (std::size_t q = 0; q < quantity_count; ++q) {
    if (!measured[q]) continue;
    const Prediction p = surface.process[q]->predict(u);
    // Seeds scatter: that noise stands between the surface and the measured value too.
    const double own = measured[q]->error * measured[q]->error + surface.process[q]->noise_variance();
    const double variance = own + p.variance;
    const double miss = measured[q]->value - p.mean;
    point.log_likelihood -= 0.5 * (miss * miss / variance + std::log(variance));
    point.doubt += p.variance / own;
  }
  return point;
}

Marginal marginal_of(const std::vector<double>& axis, const std::vector<double>& weight) {
  Marginal m;
  double total = 0.0;
  for (std::size_t i = 0; i < axis.size(); ++i) m.mean += weight[i] * axis[i];
  m.low = axis.front();
  m.high = axis.back();
  for (std::size_t i = 0; i < axis.size(); ++i) {
    if (total < 0.05) m.low = axis[i];
    total += weight[i];
    if (total >= 0.95) {
      m.high = axis[i];
      break;
    }
  }
  m.determined = m.high - m.low < 0.5 * 0.9 * (axis.back() - axis.front());
  return m;
}

std::string describe(const Calibration& c) {
  std::string text;
  if (!c.friction.determined)
    text += fmt::format("Friction is not determined: 90 % of the probability spreads over {:.2f} to {:.2f}. ",
                        c.friction.low, c.friction.high);
  if (!c.log10_modulus.determined)
    text += fmt::format(
        "The shear modulus is not determined: 90 % of the probability spreads over {:.2g} to {:.2g} Pa; "
        "choose it for the time "
        "step. ",
        std::pow(10.0, c.log10_modulus.low), std::pow(10.0, c.log10_modulus.high));
  if (std::abs(c.correlation) > 0.7)
    text += fmt::format("Friction and shear modulus trade off against each other (correlation {:.2f}). ",
                        c.correlation);
  if (text.empty()) text = "Friction and shear modulus are both determined. ";
  text.pop_back();
  return text;
}

}  // namespace

Measurements read_measurements(const yaml::Map& map) {
  Measurements measured;
  bool any = false;
  for (std::size_t q = 0; q < quantity_count; ++q) {
    const auto entry = map.optional_map(quantity_names[q]);
    if (!entry) continue;
    measured[q] = Measured{entry->number("value"), entry->number("stderr", yaml::positive())};
    entry->finish();
    any = true;
  }
  if (!any) map.fail("cohesion", "at least one of cohesion, friction_angle and angle_of_repose is needed");
  map.finish();
  return measured;
}

Calibration calibrate(const Measurements& measured, const CalibrationSettings& s, const Simulate& simulate,
                      std::vector<Evaluation> known,
                      const std::function<void(const std::vector<Evaluation>&)>& done) {
  if (s.initial_points < 3 || s.largest_points < s.initial_points)
    throw Error("calibrate: at least three points are needed to start, and no fewer in all than to start");
  const Scaling scaling{s};
  Calibration result;
  result.evaluations = std::move(known);
  const double shift = Random(s.seed).uniform();
  const auto add = [&](const Eigen::Vector2d& u) {
    result.evaluations.push_back(simulate(scaling.from_unit(u)));
    if (done) done(result.evaluations);
  };
  const auto count = [&] { return static_cast<int>(result.evaluations.size()); };
  while (count() < s.initial_points) add(even_point(count(), shift));

  const auto cell = [](int i) { return (static_cast<double>(i) + 0.5) / grid; };
  Surface surface = learn(measured, result.evaluations, scaling);
  std::vector<Point> points(grid * grid);
  const auto survey = [&] {
    double best = -std::numeric_limits<double>::infinity();
    for (int j = 0; j < grid; ++j)
      for (int i = 0; i < grid; ++i) {
        Point& p = points[j * grid + i];
        p = judge(measured, surface, {cell(i), cell(j)});
        best = std::max(best, p.log_likelihood);
      }
    double sum = 0.0;
    result.posterior.assign(points.size(), 0.0);
    for (std::size_t k = 0; k < points.size(); ++k)
      sum += result.posterior[k] = std::exp(points[k].log_likelihood - best);
    for (double& p : result.posterior) p /= sum;
  };
  survey();
  while (count() < s.largest_points) {
    // Where probability times doubt is largest; done when the surface is known better than the measurements.
    double doubt = 0.0;
    std::size_t next = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      doubt += result.posterior[k] * points[k].doubt;
      if (result.posterior[k] * points[k].doubt > result.posterior[next] * points[next].doubt) next = k;
    }
    if (doubt < 0.1 && count() > s.initial_points) break;
    add({cell(static_cast<int>(next) % grid), cell(static_cast<int>(next) / grid)});
    surface = learn(measured, result.evaluations, scaling);
    survey();
  }

  const auto best = static_cast<int>(std::max_element(result.posterior.begin(), result.posterior.end()) -
                                     result.posterior.begin());
  const Eigen::Vector2d best_unit(cell(best % grid), cell(best / grid));
  result.best = scaling.from_unit(best_unit);
  for (std::size_t q = 0; q < quantity_count; ++q) {
    result.predicted[q] = result.predicted_error[q] = std::numeric_limits<double>::quiet_NaN();
    if (!measured[q]) continue;
    const Prediction p = surface.process[q]->predict(best_unit);
    result.predicted[q] = p.mean;
    result.predicted_error[q] = std::sqrt(p.variance + surface.process[q]->noise_variance());
  }
  std::vector<double> over_friction(grid, 0.0);
  std::vector<double> over_modulus(grid, 0.0);
  for (int i = 0; i < grid; ++i) {
    const GrainParameters p = scaling.from_unit({cell(i), cell(i)});
    result.grid_friction.push_back(p.friction);
    result.grid_log10_modulus.push_back(std::log10(p.shear_modulus));
    for (int j = 0; j < grid; ++j) {
      over_friction[i] += result.posterior[j * grid + i];
      over_modulus[i] += result.posterior[i * grid + j];
    }
  }
  result.friction = marginal_of(result.grid_friction, over_friction);
  result.log10_modulus = marginal_of(result.grid_log10_modulus, over_modulus);
  double sff = 0.0, smm = 0.0, sfm = 0.0;
  for (int j = 0; j < grid; ++j)
    for (int i = 0; i < grid; ++i) {
      const double p = result.posterior[j * grid + i];
      const double f = result.grid_friction[i] - result.friction.mean;
      const double m = result.grid_log10_modulus[j] - result.log10_modulus.mean;
      sff += p * f * f;
      smm += p * m * m;
      sfm += p * f * m;
    }
  result.correlation = sff > 0.0 && smm > 0.0 ? sfm / std::sqrt(sff * smm) : 0.0;
  result.undetermined = describe(result);
  return result;
}

Simulate bulk_tests(const dem::GranularSoil& soil, const Measurements& measured, const TestSettings& t) {
  return [soil, measured, t](const GrainParameters& p) {
    dem::GranularSoil trial = soil;
    trial.grain_grain.friction = p.friction;
    trial.grain.shear_modulus = p.shear_modulus;
    Evaluation e;
    e.at = p;
    e.value.fill(std::numeric_limits<double>::quiet_NaN());
    if (measured[cohesion] || measured[friction_angle]) {
      ShearSettings s;
      s.rate = t.shear_rate;
      s.travel = t.travel;
      s.consolidation_time = 0.1;
      s.normal_stresses = {20e3, 40e3, 70e3};
      s.threads = t.threads;
      const ShearResult result = direct_shear(trial, s);
      e.value[cohesion] = result.cohesion();
      e.value[friction_angle] = result.friction_angle();
    }
    if (measured[angle_of_repose_quantity]) {
      ReposeSettings s;
      s.clumps = t.heap_clumps;
      s.threads = t.threads;
      e.value[angle_of_repose_quantity] = angle_of_repose(trial, s).angle;
    }
    return e;
  };
}

}  // namespace wheel_twin::bulk
