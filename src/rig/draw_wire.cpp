#include "rig/draw_wire.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::rig {
namespace {

constexpr double turn = 2.0 * 3.14159265358979323846;

}  // namespace

DrawWire::DrawWire(const DrawWireSettings& settings, std::uint64_t seed)
    : settings_(settings), random_(seed, 2), clock_(settings.rate), phase_(random_.uniform(0.0, turn)) {}

void DrawWire::observe(double time, double displacement, double delay, run_log::ScalarSeries& series) {
  const double start = started_ ? last_ : displacement;
  clock_.until(time, [&](double due, double share) {
    series.time.push_back(due + delay);
    series.value.push_back(reading(start + share * (displacement - start)));
  });
  started_ = true;
  last_ = displacement;
}

double DrawWire::reading(double displacement) {
  const double wire = std::clamp(settings_.wire_at_zero + displacement, 0.0, settings_.range);
  double value =
      wire - settings_.wire_at_zero + linearity_error(wire) - linearity_error(settings_.wire_at_zero);
  if (settings_.noise > 0.0) value += settings_.noise * random_.normal();
  return quantised(value, settings_.resolution);
}

/// One wave over the range: the simplest curve that a data sheet's linearity allows.
double DrawWire::linearity_error(double wire) const {
  return settings_.linearity * settings_.range * std::sin(turn * wire / settings_.range + phase_);
}

}  // namespace wheel_twin::rig
