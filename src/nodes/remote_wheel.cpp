#include "nodes/remote_wheel.h"

#include <fmt/format.h>

#include "base/error.h"
#include "nodes/coupling_conversion.h"
#include "nodes/patience.h"

namespace wheel_twin::nodes {

RemoteWheel::RemoteWheel(const ros::NodeHandle& node, double patience, std::function<bool()> quit)
    : link_(node, "rig/hub_motion", "wheel/hub_load", "flexible_wheel", std::move(quit)),
      patience_(patience),
      run_(ros::WallTime::now().toNSec()) {}

RemoteWheel::~RemoteWheel() {
  close("virtual_rig ends");
}

boost::shared_ptr<HubMotion> RemoteWheel::request(std::uint8_t kind) {
  const auto message = boost::make_shared<HubMotion>();
  message->header.frame_id = "rig";
  message->run = run_;
  message->step = step_;
  message->request = kind;
  return message;
}

boost::shared_ptr<const HubLoad> RemoteWheel::ask(const boost::shared_ptr<const HubMotion>& question,
                                                  double patience) {
  link_.send(question);
  for (;;) {
    const auto answer = link_.receive(patience);
    if (answer->run != run_) continue;  // of a run that was cut short
    if (!answer->failure.empty()) throw Error(answer->failure);
    if (answer->step != question->step || answer->request != question->request)
      throw Error(fmt::format("an answer to step {} came for step {}", answer->step, question->step));
    return answer;
  }
}

RemoteWheel::Opening RemoteWheel::open(const std::string& checkpoint) {
  link_.meet(patience_);
  const auto question = request(HubMotion::OPEN);
  question->text = checkpoint;
  open_ = true;
  const auto answer = ask(question, bed_patience(patience_));
  return {answer->wheel, answer->soil, answer->settings, answer->clearance};
}

rig::HubLoad RemoteWheel::advance(const rig::HubMotion& motion) {
  const auto question = request(HubMotion::STEP);
  put(motion, *question);
  try {
    const auto answer = ask(question, end_patience(patience_));
    ++step_;
    replaying_ = answer->replayed != 0;
    return from_message(*answer);
  } catch (const Error& error) {
    throw Error(fmt::format("step {}, at {:.3f} s: {}", step_, motion.time, error.what()));
  }
}

void RemoteWheel::write_checkpoint(const std::string& path) {
  const auto question = request(HubMotion::CHECKPOINT);
  question->text = path;
  ask(question, end_patience(patience_));
}

void RemoteWheel::hold() {
  link_.send(request(HubMotion::HOLD));
}

void RemoteWheel::close(const std::string& why) {
  if (!open_) return;
  open_ = false;
  const auto question = request(HubMotion::CLOSE);
  question->text = why;
  link_.send(question);
}

}  // namespace wheel_twin::nodes
