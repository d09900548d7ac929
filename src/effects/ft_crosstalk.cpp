// Pitch torque that leaks into the reading of the longitudinal force.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class FtCrosstalk final : public Effect, public rig::SensorPort {
 public:
  explicit FtCrosstalk(const std::vector<double>& values) : fx_per_my_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_wrench(const rig::RigState&, rig::WrenchReading& reading) const override {
    reading.force.x() += fx_per_my_ * reading.torque.y();
  }

 private:
  double fx_per_my_;
};

}  // namespace

EffectType ft_crosstalk() {
  return {
      "ft_crosstalk",
      Place::sensor,
      {{"fx_per_my", "N/(N m)", -20.0, 20.0, 1.0, 0.0}},
      "Have the sensor recalibrated; load it with a pure torque and read Fx.",
      "Pitch torque follows drawbar pull, so that this looks like gain_x; load and slip steps separate them.",
      construct<FtCrosstalk>};
}

}  // namespace wheel_twin::effects
