// A declared rig and a run on the grid of the diagnosis, for tests of its parts.
#pragma once

#include "rig/speeds.h"
#include "twin/run_grid.h"
#include "twin/twin_config.h"

namespace wheel_twin::twin {

/// What an operator would declare: a wheel with grousers on a soil whose contact turns with slip.
inline TwinConfig declared_rig() {
  TwinConfig twin;
  twin.wheel.grousers = 16;
  twin.wheel.grouser_height = 0.007;
  twin.wheel.stiffness = 24500.0;
  twin.soil.c1 = 0.2;
  return twin;
}

/// A run of `n` bins of half a second at one slip and load that stands still for its first ten bins.
inline RunGrid steady_run(double slip, double load, int n = 120, double radius = 0.09) {
  RunGrid grid;
  grid.name = "run";
  grid.declared.slip = slip;
  grid.declared.load = load;
  grid.declared.wheel_speed = 0.2859;
  grid.bin = 0.5;
  grid.measured.setZero(channel_rows, n);
  grid.slip.setConstant(n, slip);
  const rig::Speeds speeds = rig::speeds_of_slip(slip, 0.2859, radius);
  double x = 0.0, angle = 0.0;
  for (int i = 0; i < n; ++i) {
    const bool moves = i >= 10;
    rig::MeasuredMotion m;
    m.time = (i + 0.5) * grid.bin;
    m.carriage_velocity = moves ? speeds.carriage : 0.0;
    m.wheel_rate = moves ? speeds.wheel : 0.0;
    x += m.carriage_velocity * grid.bin;
    angle += m.wheel_rate * grid.bin;
    m.carriage_position = x;
    m.wheel_angle = angle;
    m.load = load;
    grid.motion.push_back(m);
    grid.moving.push_back(moves);
  }
  return grid;
}

}  // namespace wheel_twin::twin
