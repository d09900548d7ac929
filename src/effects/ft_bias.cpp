// A constant added to the force readings: a tare taken with a load on, or none taken.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class FtBias final : public Effect, public rig::SensorPort {
 public:
  explicit FtBias(const std::vector<double>& values) : force_(values[0], values[1], values[2]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_wrench(const rig::RigState&, rig::WrenchReading& reading) const override {
    reading.force += force_;
  }

 private:
  Eigen::Vector3d force_;
};

}  // namespace

EffectType ft_bias() {
  return {"ft_bias",
          Place::sensor,
          {{"force_x", "N", -50.0, 50.0, 2.0, 0.0},
           {"force_y", "N", -50.0, 50.0, 2.0, 0.0},
           {"force_z", "N", -50.0, 50.0, 2.0, 0.0}},
          "Take a new tare with the wheel hanging free.",
          "force_z alone looks like dead_weight_error, which also changes sinkage and drawbar pull.",
          construct<FtBias>};
}

}  // namespace wheel_twin::effects
