// The asking end of a lock-step exchange (nodes/link.h): every question carries the number of the run and of
// the step, and waits for the answer with the same numbers.
#pragma once

#include <boost/make_shared.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/error.h"
#include "nodes/link.h"

namespace wheel_twin::nodes {

template <typename Question, typename Answer>
class Asker {
 public:
  /// `failure_of`: put before what the other side tells of a failure.
  Asker(const ros::NodeHandle& node, const std::string& out, const std::string& in, const std::string& peer,
        std::string failure_of, std::function<bool()> quit)
      : link_(node, out, in, peer, std::move(quit)), failure_of_(std::move(failure_of)) {}

  /// A new run begins, of a number that no run before it had; waits for the other side.
  void begin(std::uint64_t run, double patience) {
    run_ = run;
    step_ = 0;
    link_.meet(patience);
    open_ = true;
  }
  void set_step(std::uint64_t step) { step_ = step; }
  std::uint64_t step() const { return step_; }

  boost::shared_ptr<Question> question(std::uint8_t kind) const {
    const auto message = boost::make_shared<Question>();
    message->header.frame_id = "rig";
    message->run = run_;
    message->step = step_;
    message->request = kind;
    return message;
  }

  /// Throws Error when the other side fails, is gone, stalls, or answers another step.
  boost::shared_ptr<const Answer> ask(const boost::shared_ptr<const Question>& question, double patience) {
    link_.send(question);
    for (;;) {
      const boost::shared_ptr<const Answer> answer = link_.receive(patience);
      if (answer->run != run_) continue;  // of a run that was cut short
      if (!answer->failure.empty()) throw Error(failure_of_ + answer->failure);
      if (answer->step != question->step || answer->request != question->request)
        throw Error(
            fmt::format("{} answered its step {} to step {}", link_.peer(), answer->step, question->step));
      return answer;
    }
  }

  void hold() { link_.send(question(Question::HOLD)); }

  void close(const std::string& why) {
    if (!open_) return;
    open_ = false;
    const auto last = question(Question::CLOSE);
    last->text = why;
    link_.send(last);
  }

 private:
  Link<Question, Answer> link_;
  std::string failure_of_;
  std::uint64_t run_ = 0, step_ = 0;
  bool open_ = false;
};

}  // namespace wheel_twin::nodes
