// Gaussian-process regression on a handful of points: Matern 5/2 covariance with one length a dimension,
// constant mean, noise; lengths and noise by the largest marginal likelihood on a grid (Rasmussen and
// Williams, 2006, ch. 2 and 5). Inputs are expected in about [0, 1].
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace wheel_twin::bulk {

struct Prediction {
  double mean = 0.0;
  double variance = 0.0;  ///< of the function, without the noise
};

class GaussianProcess {
 public:
  /// One row of `inputs` a point, at least three. Throws Error when there are fewer or a value is not finite.
  GaussianProcess(Eigen::MatrixXd inputs, const Eigen::VectorXd& values);

  Prediction predict(const Eigen::VectorXd& input) const;
  double noise_variance() const { return noise_; }             ///< of one observation
  const Eigen::VectorXd& lengths() const { return lengths_; }  ///< in units of the inputs

 private:
  double fit(const Eigen::VectorXd& values, const Eigen::VectorXd& lengths,
             double noise_ratio);  // log likelihood
  double correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;

  Eigen::MatrixXd inputs_;
  Eigen::VectorXd lengths_;
  Eigen::VectorXd weights_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  double mean_ = 0.0, variance_ = 0.0, noise_ = 0.0;
};

}  // namespace wheel_twin::bulk
