#include "twin/plate_fit.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"

namespace wheel_twin::twin {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double shallowest = 0.002;    // m: above, the plate's edge and the surface's roughness speak
constexpr double weakest = 1.0;         // N: below, the tare does
constexpr int points_per_test = 30;     // evenly over depth; more would be the same test again
constexpr double contact_force = 30.0;  // N: from here a rigid floor's push is the rig's own spring

struct Points {
  const PressCurve* curve = nullptr;
  std::vector<double> log_depth;     // of depth / reference
  std::vector<double> log_pressure;  // of pressure in Pa
};

struct Line {
  double intercept = 0.0, slope = 0.0;
};

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    n += 1.0, sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {(sy - slope * sx) / n, slope};
}

Estimate mean_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0.0, variance = 0.0;
  for (const double v : values) mean += v / n;
  for (const double v : values) variance += (v - mean) * (v - mean) / std::max(n - 1.0, 1.0);
  return {mean, std::sqrt(variance / n)};
}

std::optional<Estimate> rig_compliance(const std::vector<PressCurve>& curves) {
  std::vector<double> values;
  for (const PressCurve& curve : curves) {
    if (curve.indenter != "rigid_floor") continue;
    std::vector<double> force, depth;
    for (std::size_t i = 0; i < curve.force.size(); ++i)
      if (curve.force[i] > contact_force) force.push_back(curve.force[i]), depth.push_back(curve.depth[i]);
    if (force.size() > 20) values.push_back(fit_line(force, depth).slope);
  }
  if (values.empty()) return std::nullopt;
  return mean_of(values);
}

Points points_of(const PressCurve& curve, double compliance, double reference) {
  Points points;
  points.curve = &curve;
  std::vector<double> depth;
  for (std::size_t i = 0; i < curve.force.size(); ++i)
    depth.push_back(curve.depth[i] - compliance * curve.force[i]);
  const double deepest = *std::max_element(depth.begin(), depth.end());
  const double area = 0.25 * pi * curve.diameter * curve.diameter;
  std::size_t i = 0;
  for (int k = 1; k <= points_per_test; ++k) {
    const double from = shallowest + (deepest - shallowest) * (k - 1) / points_per_test;
    const double to = shallowest + (deepest - shallowest) * k / points_per_test;
    double n = 0.0, z = 0.0, f = 0.0;
    for (i = 0; i < depth.size(); ++i)
      if (depth[i] >= from && depth[i] < to && curve.force[i] > weakest)
        n += 1.0, z += depth[i], f += curve.force[i];
    if (n == 0.0) continue;
    points.log_depth.push_back(std::log(z / n / reference));
    points.log_pressure.push_back(std::log(f / n / area));
  }
  return points;
}

// ln p = ln(k_c / b + k_phi at the reference depth) + u + (n + v) ln(z / reference); k in units of `scale`.
struct PressureResidual {
  double log_depth, log_pressure, reference_over_b, log_scale, sigma;
  template <typename T>
  bool operator()(const T* k_c, const T* k_phi, const T* n, const T* own, T* residual) const {
    const T k = *k_c * reference_over_b + *k_phi;
    if (!(k > T(1e-9))) return false;
    using std::log;
    residual[0] = (log(k) + log_scale + own[0] + (*n + own[1]) * log_depth - log_pressure) / sigma;
    return true;
  }
};

struct PriorResidual {
  double spread_pressure, spread_exponent;
  template <typename T>
  bool operator()(const T* own, T* residual) const {
    residual[0] = own[0] / spread_pressure;
    residual[1] = own[1] / spread_exponent;
    return true;
  }
};

struct State {
  double k_c = 0.0, k_phi = 1.0, n = 1.0;  // k in units of scale
  std::vector<std::array<double, 2>> own;
};

}  // namespace

PlateFit fit_plates(const std::vector<PressCurve>& curves, double width) {
  PlateFit fit;
  fit.compliance = rig_compliance(curves);
  const double compliance = fit.compliance ? fit.compliance->value : 0.0;
  // About where a wheel runs, and where the tests' own lines are best known.
  fit.reference_depth = 0.015;
  std::vector<Points> tests;
  std::set<double> diameters;
  for (const PressCurve& curve : curves) {
    if (curve.indenter != "plate") continue;
    Points points = points_of(curve, compliance, fit.reference_depth);
    if (points.log_depth.size() < 5)
      throw Error(fmt::format("{}: fewer than 5 depths with a force above {} N below {} mm", curve.name,
                              weakest, 1e3 * shallowest));
    tests.push_back(std::move(points));
    diameters.insert(curve.diameter);
  }
  if (tests.size() < 2) throw Error(fmt::format("{} plate tests are too few to fit a soil", tests.size()));
  fit.separate = diameters.size() > 1;

  State state;
  double log_scale = 0.0;
  state.n = 0.0;
  for (const Points& test : tests) {
    const Line line = fit_line(test.log_depth, test.log_pressure);
    log_scale += line.intercept / static_cast<double>(tests.size());
    state.n += line.slope / static_cast<double>(tests.size());
  }
  state.own.assign(tests.size(), {0.0, 0.0});
  double spread_u = 0.2, spread_v = 0.2, sigma = 0.1;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int pass = 0; pass < 30; ++pass) {  // empirical Bayes: the spreads from the effects, and again
    ceres::Problem problem;
    for (std::size_t t = 0; t < tests.size(); ++t) {
      for (std::size_t i = 0; i < tests[t].log_depth.size(); ++i)
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<PressureResidual, 1, 1, 1, 1, 2>(
                new PressureResidual{tests[t].log_depth[i], tests[t].log_pressure[i],
                                     fit.reference_depth / tests[t].curve->diameter, log_scale, sigma}),
            new ceres::HuberLoss(2.0), &state.k_c, &state.k_phi, &state.n, state.own[t].data());
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PriorResidual, 2, 2>(new PriorResidual{spread_u, spread_v}),
          nullptr, state.own[t].data());
    }
    if (!fit.separate) problem.SetParameterBlockConstant(&state.k_c);
    ceres::Solver::Options options;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable())
      throw Error(fmt::format("plate tests: the fit failed: {}", summary.message));

    ceres::Covariance::Options covariance_options;
    covariance_options.algorithm_type = ceres::DENSE_SVD;
    ceres::Covariance estimator(covariance_options);
    std::vector<const double*> blocks = {&state.k_c, &state.k_phi, &state.n};
    for (const auto& own : state.own) blocks.push_back(own.data());
    if (!estimator.Compute(blocks, &problem)) throw Error("plate tests: the fit is degenerate");
    const std::array<const double*, 3> common = {&state.k_c, &state.k_phi, &state.n};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        estimator.GetCovarianceBlock(common[static_cast<std::size_t>(a)], common[static_cast<std::size_t>(b)],
                                     &covariance(a, b));
    double uu = 0.0, vv = 0.0, rr = 0.0, count = 0.0;
    for (std::size_t t = 0; t < tests.size(); ++t) {
      Eigen::Matrix<double, 2, 2, Eigen::RowMajor> own;
      estimator.GetCovarianceBlock(state.own[t].data(), state.own[t].data(), own.data());
      uu += state.own[t][0] * state.own[t][0] + own(0, 0);
      vv += state.own[t][1] * state.own[t][1] + own(1, 1);
      const double k = state.k_c * fit.reference_depth / tests[t].curve->diameter + state.k_phi;
      for (std::size_t i = 0; i < tests[t].log_depth.size(); ++i) {
        const double model =
            std::log(k) + log_scale + state.own[t][0] + (state.n + state.own[t][1]) * tests[t].log_depth[i];
        rr += std::pow(model - tests[t].log_pressure[i], 2);
        count += 1.0;
      }
    }
    const auto tests_count = static_cast<double>(tests.size());
    spread_u = std::max(std::sqrt(uu / tests_count), 1e-4);
    spread_v = std::max(std::sqrt(vv / tests_count), 1e-4);
    sigma = std::max(std::sqrt(rr / count), 1e-4);
  }
  fit.between_tests_pressure = spread_u;
  fit.between_tests_exponent = spread_v;
  fit.within_test = sigma;

  // Back to Bekker's units: K = k scale reference^-n, and with it the uncertainty of n comes in.
  const double reference = fit.reference_depth, n = state.n;
  const double unit = std::exp(log_scale) * std::pow(reference, -n);
  fit.n = {n, std::sqrt(covariance(2, 2))};
  fit.k_c.value = state.k_c * unit * reference;
  fit.k_phi.value = state.k_phi * unit;
  const Eigen::Vector3d d_k_c(unit * reference, 0.0, -fit.k_c.value * std::log(reference));
  const Eigen::Vector3d d_k_phi(0.0, unit, -fit.k_phi.value * std::log(reference));
  fit.k_c.standard_error = std::sqrt(d_k_c.dot(covariance * d_k_c));
  fit.k_phi.standard_error = std::sqrt(d_k_phi.dot(covariance * d_k_phi));
  const double k_width = state.k_c * reference / width + state.k_phi;
  if (!(k_width > 0.0))
    throw Error(fmt::format("plate tests: the fitted modulus at the wheel's width of {} mm is not above 0",
                            1e3 * width));
  const Eigen::Vector3d d_log(reference / width / k_width, 1.0 / k_width, 0.0);
  fit.relative_error_at_width = std::sqrt(d_log.dot(covariance * d_log));
  for (std::size_t t = 0; t < tests.size(); ++t) {
    const double k = state.k_c * reference / tests[t].curve->diameter + state.k_phi;
    fit.tests.push_back({tests[t].curve->name, tests[t].curve->diameter,
                         k * std::exp(log_scale + state.own[t][0]), n + state.own[t][1]});
  }
  return fit;
}

terramechanics::Soil soil_of_fit(const terramechanics::Soil& declared, const PlateFit& fit) {
  terramechanics::Soil soil = declared;
  soil.k_c = fit.k_c.value;
  soil.k_phi = fit.k_phi.value;
  soil.n = fit.n.value;
  return soil;
}

}  // namespace wheel_twin::twin
