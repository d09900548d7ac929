#include "twin/fit.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace wheel_twin::twin {
namespace {

/// Residuals of data and priors over x in units of `scale`, derivatives by one-sided differences that stay in
/// bounds.
class SimulationCost final : public ceres::CostFunction {
 public:
  SimulationCost(const std::vector<Unknown>& unknowns, const ResidualFunction& function, int count)
      : unknowns_(unknowns), function_(function), count_(count) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(unknowns.size()));
    set_num_residuals(count + static_cast<int>(unknowns.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const auto p = unknowns_.size();
    std::vector<double> x(p);
    for (std::size_t j = 0; j < p; ++j) x[j] = parameters[0][j] * unknowns_[j].scale;
    std::vector<double> base;
    if (!function_(x, base)) return false;
    std::copy(base.begin(), base.end(), residuals);
    for (std::size_t j = 0; j < p; ++j)
      residuals[static_cast<std::size_t>(count_) + j] =
          (x[j] - unknowns_[j].prior) / unknowns_[j].prior_deviation;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
        jacobians[0], num_residuals(), static_cast<Eigen::Index>(p));
    jacobian.setZero();
    std::vector<double> moved;
    for (std::size_t j = 0; j < p; ++j) {
      const double room_up = unknowns_[j].upper - x[j];
      const double sign = room_up > difference * unknowns_[j].scale ? 1.0 : -1.0;
      std::vector<double> near = x;
      near[j] += sign * difference * unknowns_[j].scale;
      moved.clear();
      if (!function_(near, moved)) return false;
      for (int i = 0; i < count_; ++i)
        jacobian(i, static_cast<Eigen::Index>(j)) =
            (moved[static_cast<std::size_t>(i)] - base[static_cast<std::size_t>(i)]) / (sign * difference);
      jacobian(count_ + static_cast<int>(j), static_cast<Eigen::Index>(j)) =
          unknowns_[j].scale / unknowns_[j].prior_deviation;
    }
    return true;
  }

 private:
  static constexpr double difference = 2e-3;  // of the scale
  const std::vector<Unknown>& unknowns_;
  const ResidualFunction& function_;
  int count_;
};

}  // namespace

FitResult least_squares(const std::vector<Unknown>& unknowns, const ResidualFunction& function,
                        int max_iterations) {
  FitResult result;
  std::vector<double> start;
  for (const Unknown& u : unknowns) start.push_back(std::clamp(u.start, u.lower, u.upper));
  std::vector<double> probe;
  if (!function(start, probe)) return result;
  const int count = static_cast<int>(probe.size());
  if (unknowns.empty()) {
    result.usable = true;
    result.residuals = std::move(probe);
    result.cost = 0.0;
    for (const double r : result.residuals) result.cost += 0.5 * r * r;
    return result;
  }

  SimulationCost cost(unknowns, function, count);
  std::vector<double> z(unknowns.size());
  for (std::size_t j = 0; j < z.size(); ++j) z[j] = start[j] / unknowns[j].scale;
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  problem.AddResidualBlock(&cost, nullptr, z.data());
  for (std::size_t j = 0; j < z.size(); ++j) {
    if (std::isfinite(unknowns[j].lower))
      problem.SetParameterLowerBound(z.data(), static_cast<int>(j), unknowns[j].lower / unknowns[j].scale);
    if (std::isfinite(unknowns[j].upper))
      problem.SetParameterUpperBound(z.data(), static_cast<int>(j), unknowns[j].upper / unknowns[j].scale);
  }
  ceres::Solver::Options solver;
  solver.max_num_iterations = max_iterations;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.logging_type = ceres::SILENT;
  solver.function_tolerance = 1e-5;
  solver.parameter_tolerance = 1e-6;
  solver.max_num_consecutive_invalid_steps = 8;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) return result;

  const auto p = static_cast<Eigen::Index>(z.size());
  std::vector<double> all(static_cast<std::size_t>(cost.num_residuals()));
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian(cost.num_residuals(), p);
  const double* blocks[] = {z.data()};
  double* jacobians[] = {jacobian.data()};
  if (!cost.Evaluate(blocks, all.data(), jacobians)) return result;
  result.usable = true;
  result.cost = summary.final_cost;
  result.residuals.assign(all.begin(), all.begin() + count);
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  information.diagonal().array() += 1e-12 * std::max(1.0, information.diagonal().maxCoeff());
  const Eigen::MatrixXd inverse = information.inverse();
  result.covariance.resize(p, p);
  for (Eigen::Index i = 0; i < p; ++i) {
    result.x.push_back(z[static_cast<std::size_t>(i)] * unknowns[static_cast<std::size_t>(i)].scale);
    for (Eigen::Index j = 0; j < p; ++j)
      result.covariance(i, j) = inverse(i, j) * unknowns[static_cast<std::size_t>(i)].scale *
                                unknowns[static_cast<std::size_t>(j)].scale;
  }
  return result;
}

}  // namespace wheel_twin::twin
