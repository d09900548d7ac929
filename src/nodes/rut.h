// The soil surface under the wheel's path as a person sees it: the wheel presses it down to its sinkage,
// behind the wheel it comes back by the share gamma of the sinkage (exit angle theta_2 of the paper's Section
// 2), grousers leave their marks where they leave the soil. Shown only; no force comes from it. Frame `rig`,
// metres.
#pragma once

#include <vector>

namespace wheel_twin::nodes {

struct RutSettings {
  double begin = -0.2275;  ///< x of the first column, m
  double end = 0.9275;     ///< x of the last column, m
  double spacing = 0.004;  ///< between columns, m, above 0
  double radius = 0.09;    ///< of the wheel without grousers, m
  int grousers = 0;
  double grouser_height = 0.0;  ///< m
  double rebound = 0.3;  ///< share of the sinkage by which the soil comes back, 0 to 1 (the soil's gamma)
};

class Rut {
 public:
  explicit Rut(const RutSettings& settings);

  /// The wheel at `x` with the lowest point of its rim `sinkage` below the undisturbed surface (nothing at 0
  /// or less), turned by `wheel_angle`, rad, positive rolling towards +x.
  void roll(double x, double sinkage, double wheel_angle);

  const RutSettings& settings() const { return settings_; }
  std::size_t size() const { return height_.size(); }
  double x(std::size_t column) const {
    return settings_.begin + settings_.spacing * static_cast<double>(column);
  }
  /// Surface over the undisturbed one, at most 0, m.
  double height(std::size_t column) const { return height_[column]; }
  double deepest() const;

 private:
  void mark_grousers(double x, double exit_angle, double wheel_angle);

  RutSettings settings_;
  std::vector<double> height_;
  double last_angle_ = 0.0;
  bool rolling_ = false;
};

}  // namespace wheel_twin::nodes
