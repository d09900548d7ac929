// The answering end of a lock-step exchange (nodes/link.h): serves run after run, gives every question an
// answer with the same numbers of run and step, and says why it can not go on: once to people, once to the
// side that asks.
#pragma once

#include <ros/console.h>

#include <boost/make_shared.hpp>
#include <cstdint>
#include <exception>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/error.h"
#include "nodes/link.h"

namespace wheel_twin::nodes {

struct AnsweringSide {
  std::string name;        ///< of the node, in messages to people
  std::string idle;        ///< its status between runs
  double patience = 30.0;  ///< s that the side that asks may be silent during a run
  std::function<bool()> quit;
  std::function<void(const std::string&)> status;  ///< running, `idle`, failed: why
};

template <typename Question, typename Answer>
class Answerer {
 public:
  Answerer(const ros::NodeHandle& node, const std::string& out, const std::string& in,
           const std::string& peer, AnsweringSide side)
      : side_(std::move(side)), link_(node, out, in, peer, side_.quit) {}
  virtual ~Answerer() = default;
  Answerer(const Answerer&) = delete;
  Answerer& operator=(const Answerer&) = delete;

  /// Until the node ends.
  void serve() {
    for (;;) {
      boost::shared_ptr<const Question> question;
      try {
        question = open_ && !held_ ? link_.receive(side_.patience) : link_.receive_any();
        if (question->request != Question::OPEN && (!open_ || question->run != run_)) continue;
        held_ = question->request == Question::HOLD;
        take(*question);
      } catch (const NodeEnds&) {
        drop(side_.name + " ends");
        return;
      } catch (const std::exception& error) {
        fail(question.get(), error.what());
      }
    }
  }

 private:
  virtual void open(const Question& question, Answer& answer) = 0;
  virtual void step(const Question& question, Answer& answer) = 0;
  virtual void checkpoint(const Question& question, Answer& answer) = 0;
  virtual void hold() {}
  /// After every step that was answered; `at_rest`: when time stands still and at the end.
  virtual void show(bool at_rest) = 0;
  /// The run is over, or could not be opened; `why`: what cut it short, or empty.
  virtual void drop(const std::string& why) = 0;

  void take(const Question& question) {
    const boost::shared_ptr<Answer> answer = answer_to(question);
    switch (question.request) {
      case Question::OPEN:
        close("another run begins");
        run_ = question.run;
        link_.meet(side_.patience);
        open(question, *answer);
        open_ = true;
        link_.send(answer);
        side_.status("running");
        break;
      case Question::STEP:
        step(question, *answer);
        link_.send(answer);
        show(false);
        break;
      case Question::CHECKPOINT:
        checkpoint(question, *answer);
        link_.send(answer);
        break;
      case Question::HOLD:
        hold();
        show(true);
        break;
      case Question::CLOSE:
        close(question.text);
        break;
      default:
        throw Error(fmt::format("request {} is not known", question.request));
    }
  }

  void close(const std::string& why) {
    if (!open_) return;
    show(true);
    open_ = false;
    drop(why);
    if (!why.empty()) ROS_ERROR("%s: the run is cut short: %s", side_.name.c_str(), why.c_str());
    side_.status(side_.idle);
  }

  void fail(const Question* question, const std::string& why) {
    ROS_ERROR("%s: %s", side_.name.c_str(), why.c_str());
    open_ = held_ = false;
    drop(why);
    side_.status("failed: " + why);
    if (question == nullptr) return;
    const boost::shared_ptr<Answer> answer = answer_to(*question);
    answer->failure = why;
    link_.send(answer);
  }

  static boost::shared_ptr<Answer> answer_to(const Question& question) {
    const auto answer = boost::make_shared<Answer>();
    answer->header.frame_id = "rig";
    answer->run = question.run;
    answer->step = question.step;
    answer->request = question.request;
    return answer;
  }

  AnsweringSide side_;
  Link<Answer, Question> link_;
  std::uint64_t run_ = 0;
  bool open_ = false, held_ = false;
};

}  // namespace wheel_twin::nodes
