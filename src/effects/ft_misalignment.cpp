// The sensor mounted askew: reading = Ry(pitch) Rx(roll) true, forces and torques alike.
#include "effects/catalogue.h"

#include <Eigen/Geometry>

namespace wheel_twin::effects {
namespace {

class FtMisalignment final : public Effect, public rig::SensorPort {
 public:
  explicit FtMisalignment(const std::vector<double>& values) : pitch_(values[0]), roll_(values[1]) {}

  void attach(rig::Ports& ports) const override { ports.sensor.push_back(this); }

  void change_wrench(const rig::RigState&, rig::WrenchReading& reading) const override {
    const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(pitch_, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(roll_, Eigen::Vector3d::UnitX()))
                                         .toRotationMatrix();
    reading.force = rotation * reading.force;
    reading.torque = rotation * reading.torque;
  }

 private:
  double pitch_;
  double roll_;
};

}  // namespace

EffectType ft_misalignment() {
  return {"ft_misalignment",
          Place::sensor,
          {{"pitch", "rad", -0.35, 0.35, 0.03, 0.0}, {"roll", "rad", -0.35, 0.35, 0.03, 0.0}},
          "Check the sensor mount with a level; hang a known weight and read Fx and Fy.",
          "pitch looks like bed_tilt in drawbar pull; only a tilted bed moves the hub with distance.",
          construct<FtMisalignment>};
}

}  // namespace wheel_twin::effects
