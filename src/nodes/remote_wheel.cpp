#include "nodes/remote_wheel.h"

#include <fmt/format.h>

#include "base/error.h"
#include "nodes/coupling_conversion.h"
#include "nodes/patience.h"

namespace wheel_twin::nodes {

RemoteWheel::RemoteWheel(const ros::NodeHandle& node, double patience, std::function<bool()> quit)
    : wheel_(node, "rig/hub_motion", "wheel/hub_load", "flexible_wheel", "", std::move(quit)),
      patience_(patience) {}

RemoteWheel::~RemoteWheel() {
  close("virtual_rig ends");
}

RemoteWheel::Opening RemoteWheel::open(const std::string& checkpoint,
                                       const std::vector<std::string>& effects) {
  wheel_.begin(ros::WallTime::now().toNSec(), patience_);
  const auto question = wheel_.question(HubMotion::OPEN);
  question->text = checkpoint;
  question->effects = effects;
  const auto answer = wheel_.ask(question, bed_patience(patience_));
  return {answer->wheel, answer->soil, answer->settings, answer->clearance};
}

rig::HubLoad RemoteWheel::advance(const rig::HubMotion& motion) {
  const auto question = wheel_.question(HubMotion::STEP);
  put(motion, *question);
  try {
    const auto answer = wheel_.ask(question, end_patience(patience_));
    wheel_.set_step(wheel_.step() + 1);
    replaying_ = answer->replayed != 0;
    return from_message(*answer);
  } catch (const Error& error) {
    throw Error(fmt::format("step {}, at {:.3f} s: {}", wheel_.step(), motion.time, error.what()));
  }
}

void RemoteWheel::write_checkpoint(const std::string& path) {
  const auto question = wheel_.question(HubMotion::CHECKPOINT);
  question->text = path;
  wheel_.ask(question, end_patience(patience_));
}

void RemoteWheel::hold() {
  wheel_.hold();
}

void RemoteWheel::close(const std::string& why) {
  wheel_.close(why);
}

}  // namespace wheel_twin::nodes
