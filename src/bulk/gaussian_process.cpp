#include "bulk/gaussian_process.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"

namespace wheel_twin::bulk {
namespace {

constexpr std::array<double, 7> length_grid = {0.15, 0.25, 0.4, 0.7, 1.2, 2.5, 6.0};
constexpr std::array<double, 7> noise_grid = {1e-6, 1e-4, 1e-3, 1e-2, 0.05, 0.2, 1.0};

}  // namespace

GaussianProcess::GaussianProcess(Eigen::MatrixXd inputs, const Eigen::VectorXd& values)
    : inputs_(std::move(inputs)) {
  if (inputs_.rows() < 3 || inputs_.rows() != values.size() || !inputs_.allFinite() || !values.allFinite())
    throw Error("Gaussian process: at least three points with finite values are needed");
  const Eigen::Index dimensions = inputs_.cols();
  double best = -std::numeric_limits<double>::infinity();
  Eigen::VectorXd best_lengths;
  double best_noise = 0.0;
  // Every combination of lengths, counted like the digits of a number.
  Eigen::VectorXi digit = Eigen::VectorXi::Zero(dimensions);
  for (bool more = true; more;) {
    Eigen::VectorXd lengths(dimensions);
    for (Eigen::Index d = 0; d < dimensions; ++d) lengths[d] = length_grid[digit[d]];
    for (const double noise : noise_grid) {
      const double likelihood = fit(values, lengths, noise);
      if (likelihood > best) {
        best = likelihood;
        best_lengths = lengths;
        best_noise = noise;
      }
    }
    more = false;
    for (Eigen::Index d = 0; d < dimensions && !more; ++d) {
      more = ++digit[d] < static_cast<int>(length_grid.size());
      if (!more) digit[d] = 0;
    }
  }
  fit(values, best_lengths, best_noise);
}

double GaussianProcess::correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  const double r = std::sqrt(5.0) * ((a - b).array() / lengths_.array()).matrix().norm();
  return (1.0 + r + r * r / 3.0) * std::exp(-r);
}

double GaussianProcess::fit(const Eigen::VectorXd& values, const Eigen::VectorXd& lengths,
                            double noise_ratio) {
  lengths_ = lengths;
  const Eigen::Index n = inputs_.rows();
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) k(i, j) = correlation(inputs_.row(i), inputs_.row(j));
  k.diagonal().array() += noise_ratio + 1e-10;
  factor_.compute(k);
  if (factor_.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
  const Eigen::VectorXd k_ones = factor_.solve(ones);
  mean_ = k_ones.dot(values) / k_ones.dot(ones);
  const Eigen::VectorXd residual = values.array() - mean_;
  weights_ = factor_.solve(residual);
  variance_ = std::max(residual.dot(weights_) / static_cast<double>(n), 1e-300);
  noise_ = noise_ratio * variance_;
  const Eigen::MatrixXd l = factor_.matrixL();
  return -0.5 * static_cast<double>(n) * std::log(variance_) - l.diagonal().array().log().sum();
}

Prediction GaussianProcess::predict(const Eigen::VectorXd& input) const {
  Eigen::VectorXd k(inputs_.rows());
  for (Eigen::Index i = 0; i < k.size(); ++i) k[i] = correlation(inputs_.row(i), input);
  Prediction p;
  p.mean = mean_ + k.dot(weights_);
  // The last term is the price of an estimated mean.
  const Eigen::VectorXd solved = factor_.solve(k);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(k.size());
  const double left = 1.0 - ones.dot(solved);
  p.variance = variance_ * std::max(0.0, 1.0 - k.dot(solved) + left * left / ones.dot(factor_.solve(ones)));
  return p;
}

}  // namespace wheel_twin::bulk
