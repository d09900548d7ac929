// Force readings that follow the temperature, about 22 C.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class FtThermal final : public Effect, public rig::SensorPort {
 public:
  explicit FtThermal(const std::vector<double>& values) : per_kelvin_(values[0], values[1], values[2]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_wrench(const rig::RigState& state, rig::WrenchReading& reading) const override {
    reading.force += per_kelvin_ * (state.temperature - 22.0);
  }

 private:
  Eigen::Vector3d per_kelvin_;
};

}  // namespace

EffectType ft_thermal() {
  return {"ft_thermal",
          Place::sensor,
          {{"per_kelvin_x", "N/K", -10.0, 10.0, 0.3, 0.0},
           {"per_kelvin_y", "N/K", -10.0, 10.0, 0.3, 0.0},
           {"per_kelvin_z", "N/K", -10.0, 10.0, 0.3, 0.0}},
          "Shield the sensor from the motor and from sunlight; tare at working temperature.",
          "Needs a temperature that changes; where it only rises with time this is ft_drift.",
          construct<FtThermal>};
}

}  // namespace wheel_twin::effects
