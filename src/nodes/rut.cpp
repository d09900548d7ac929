#include "nodes/rut.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

constexpr double pi = 3.14159265358979323846;
// Loose soil falls back into the mark of a grouser; half of its height is shown.
constexpr double mark_share = 0.5;

}  // namespace

Rut::Rut(const RutSettings& settings) : settings_(settings) {
  if (!(settings.spacing > 0.0) || !(settings.end > settings.begin) || !(settings.radius > 0.0))
    throw Error("rut: spacing, length and radius must be above 0");
  height_.assign(static_cast<std::size_t>((settings.end - settings.begin) / settings.spacing + 0.5) + 1, 0.0);
}

void Rut::roll(double x, double sinkage, double wheel_angle) {
  if (!(sinkage > 0.0)) {
    rolling_ = false;
    return;
  }
  const double R = settings_.radius;
  const double z = std::min(sinkage, R);
  const double theta_1 = std::acos(1.0 - z / R);
  const double theta_2 = std::acos(1.0 - settings_.rebound * z / R);
  const double rear = x - R * std::sin(theta_2);
  const double front = x + R * std::sin(theta_1);
  const double last = static_cast<double>(height_.size() - 1);
  const double first_column = std::ceil(std::max(0.0, (rear - settings_.begin) / settings_.spacing));
  const double last_column = std::floor(std::min(last, (front - settings_.begin) / settings_.spacing));
  for (double column = first_column; column <= last_column; ++column) {
    const auto i = static_cast<std::size_t>(column);
    const double along = this->x(i) - x;
    const double rim = -z + R - std::sqrt(R * R - along * along);
    height_[i] = along > 0.0 ? std::min(height_[i], rim) : rim;
  }
  mark_grousers(rear, theta_2, wheel_angle);
}

void Rut::mark_grousers(double x, double exit_angle, double wheel_angle) {
  const bool was_rolling = rolling_;
  const double last_angle = last_angle_;
  rolling_ = true;
  last_angle_ = wheel_angle;
  if (!was_rolling || settings_.grousers == 0 || wheel_angle <= last_angle) return;
  // Grouser 0 points up at angle 0 and leaves the soil at pi + exit_angle.
  const double pitch = 2.0 * pi / settings_.grousers;
  const double passed_before = std::floor((last_angle - exit_angle - pi) / pitch);
  const double passed_now = std::floor((wheel_angle - exit_angle - pi) / pitch);
  const double column = std::ceil((x - settings_.begin) / settings_.spacing) - 1.0;  // just behind
  if (passed_now <= passed_before || column < 0.0 || column >= static_cast<double>(height_.size())) return;
  height_[static_cast<std::size_t>(column)] -= mark_share * settings_.grouser_height;
}

double Rut::deepest() const {
  return -*std::min_element(height_.begin(), height_.end());
}

}  // namespace wheel_twin::nodes
