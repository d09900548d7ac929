// Force readings too large by a fraction: another calibration file, another unit.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class FtGain final : public Effect, public rig::SensorPort {
 public:
  explicit FtGain(const std::vector<double>& values) : gain_(values[0], values[1], values[2]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_wrench(const rig::RigState&, rig::WrenchReading& reading) const override {
    reading.force = reading.force.cwiseProduct(Eigen::Vector3d::Ones() + gain_);
  }

 private:
  Eigen::Vector3d gain_;
};

}  // namespace

EffectType ft_gain() {
  return {"ft_gain",
          Place::sensor,
          {{"gain_x", "fraction", -0.9, 1.0, 0.05, 0.0},
           {"gain_y", "fraction", -0.9, 1.0, 0.05, 0.0},
           {"gain_z", "fraction", -0.9, 1.0, 0.05, 0.0}},
          "Check that the calibration matrix is the one of this sensor; hang known weights.",
          "gain_z alone looks like dead_weight_error on one load; two loads separate them.",
          construct<FtGain>};
}

}  // namespace wheel_twin::effects
