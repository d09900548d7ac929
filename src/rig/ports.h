// Where something may act on soil, wheel, rig and sensors. None of them knows what acts: an effect implements
// the ports that it needs, everything else keeps the neutral default. One object may implement several. A
// port that acts in the high-fidelity co-simulation as well is used there by the same calls.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace wheel_twin::rig {

/// Where in the run a port is asked: the true state, except the wheel angle, which has the encoder's origin.
struct RigState {
  double time = 0.0;              ///< s from the start of the run
  double x = 0.0;                 ///< carriage position from the start of the run, m
  double carriage_speed = 0.0;    ///< m/s
  double wheel_angle = 0.0;       ///< rad, as logged
  double wheel_rate = 0.0;        ///< rad/s
  double rim_travel = 0.0;        ///< m, integral of radius times |rate| since first touch
  double slip = 0.0;              ///< -1 to 1, `slip_ratio` of carriage speed and rim speed
  double hub_displacement = 0.0;  ///< true, m, positive down
  double slide_velocity = 0.0;    ///< m/s, positive up
  double steering_angle = 0.0;    ///< rad, commanded
  double temperature = 22.0;      ///< degrees C
};

class SoilPort {
 public:
  virtual ~SoilPort() = default;
  /// Factor on the pressure of the pressure-sinkage law, the same at every depth.
  virtual double stiffness_factor(const RigState&) const { return 1.0; }
  /// A further factor at depth z (m) below the undisturbed surface, asked where `layered`.
  virtual bool layered() const { return false; }
  virtual double layer_factor(const RigState&, double /*depth*/) const { return 1.0; }
  virtual double added_cohesion(const RigState&) const { return 0.0; }  ///< Pa
  /// Sinkage of the undisturbed law times this.
  virtual double sinkage_factor(const RigState&) const { return 1.0; }
  /// Force of the soil on the hub beside the contact law's own (an obstacle), rig axes, N.
  virtual Eigen::Vector3d added_force(const RigState&, double /*normal_load*/) const {
    return Eigen::Vector3d::Zero();
  }
  virtual double surface_slope(const RigState&) const { return 0.0; }  ///< rad, rising along x when positive
};

class WheelPort {
 public:
  virtual ~WheelPort() = default;
  virtual double hub_rise(const RigState&) const { return 0.0; }  ///< hub lifted over the ideal wheel, m
  virtual double rolling_resistance(const RigState&) const {
    return 0.0;
  }  ///< N off the drawbar pull while rolling
};

class RigPort {
 public:
  virtual ~RigPort() = default;
  virtual double added_dead_weight(const RigState&) const { return 0.0; }  ///< N, down
  virtual double coulomb_friction(const RigState&) const {
    return 0.0;
  }                                                                   ///< N in the vertical guide, at least 0
  virtual double speed_factor(const RigState&) const { return 1.0; }  ///< true carriage speed over logged
  virtual double added_steering(const RigState&) const { return 0.0; }  ///< rad, wheel turned left
  virtual double motor_drag(const RigState&) const { return 0.0; }      ///< N m, seen by the motor only
};

/// Changes of readings. Called in the order of the effects; the reading is what the sensor would log before
/// its own noise, resolution and filter.
struct WrenchReading {
  Eigen::Vector3d force{0.0, 0.0, 0.0};
  Eigen::Vector3d torque{0.0, 0.0, 0.0};
};

class SensorPort {
 public:
  virtual ~SensorPort() = default;
  virtual void change_wrench(const RigState&, WrenchReading&) const {}
  virtual void change_displacement(const RigState&, double /*normal_load*/, double& /*displacement*/) const {}
  virtual void change_motor_effort(const RigState&, double& /*effort, N m*/) const {}
  virtual double draw_wire_delay() const { return 0.0; }  ///< s added to the draw-wire stamps
};

/// What acts on a run; pointers are not owned.
struct Ports {
  std::vector<const SoilPort*> soil;
  std::vector<const WheelPort*> wheel;
  std::vector<const RigPort*> rig;
  std::vector<const SensorPort*> sensor;
};

/// How far the hub is lifted over the ideal wheel by all of `ports`, m.
inline double hub_rise(const Ports& ports, const RigState& state) {
  double rise = 0.0;
  for (const WheelPort* port : ports.wheel) rise += port->hub_rise(state);
  return rise;
}

/// How late all of `ports` make the draw wire's stamps, s.
inline double draw_wire_delay(const Ports& ports) {
  double delay = 0.0;
  for (const SensorPort* port : ports.sensor) delay += port->draw_wire_delay();
  return delay;
}

}  // namespace wheel_twin::rig
