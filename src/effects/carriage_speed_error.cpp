// A carriage that truly moves at the logged speed times 1 + scale_error: belt slip, wrong pulley.
#include "effects/catalogue.h"

namespace wheel_twin::effects {
namespace {

class CarriageSpeedError final : public Effect, public rig::RigPort {
 public:
  explicit CarriageSpeedError(const std::vector<double>& values) : scale_error_(values[0]) {}

  void attach(rig::Ports& ports) const override { ports.rig.push_back(this); }

  double speed_factor(const rig::RigState&) const override { return 1.0 + scale_error_; }

 private:
  double scale_error_;
};

}  // namespace

EffectType carriage_speed_error() {
  return {"carriage_speed_error",
          Place::rig,
          {{"scale_error", "fraction", -0.5, 0.5, 0.04, 0.0}},
          "Measure the travel of a run with a tape; check belt tension and pulley diameter.",
          "Acts as a shift of slip: needs runs over a range of slips.",
          construct<CarriageSpeedError>};
}

}  // namespace wheel_twin::effects
