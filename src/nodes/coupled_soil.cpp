#include "nodes/coupled_soil.h"

#include <fmt/format.h>
#include <ros/console.h>

#include <optional>

#include "base/error.h"
#include "cosim/checkpoint.h"
#include "cosim/dem_contact.h"
#include "nodes/coupling_conversion.h"
#include "nodes/link.h"
#include "nodes/patience.h"

namespace wheel_twin::nodes {
namespace {

class Server {
 public:
  Server(const ros::NodeHandle& node, const CoupledSoilSettings& settings, const CoupledSoilHooks& hooks)
      : settings_(settings),
        hooks_(hooks),
        link_(node, "soil/segment_loads", "wheel/segments", "flexible_wheel", hooks.quit) {}

  void serve() {
    for (;;) {
      boost::shared_ptr<const SegmentMotion> question;
      try {
        question = soil_ && !held_ ? link_.receive(end_patience(settings_.patience)) : link_.receive_any();
        if (question->request != SegmentMotion::OPEN && (!soil_ || question->run != run_)) continue;
        held_ = question->request == SegmentMotion::HOLD;
        take(*question);
      } catch (const NodeEnds&) {
        return;
      } catch (const std::exception& error) {
        fail(question.get(), error.what());
      }
    }
  }

 private:
  void take(const SegmentMotion& question) {
    switch (question.request) {
      case SegmentMotion::OPEN:
        open(question);
        break;
      case SegmentMotion::STEP:
        step(question);
        break;
      case SegmentMotion::CHECKPOINT: {
        const auto answer = answer_to(question);
        answer->state = dem::archive_bytes(cosim::checkpoint_kind, cosim::soil_archive(*soil_));
        link_.send(answer);
        break;
      }
      case SegmentMotion::HOLD:
        hooks_.shown(*soil_, hub_x_, true);
        break;
      case SegmentMotion::CLOSE:
        hooks_.shown(*soil_, hub_x_, true);
        soil_.reset();
        if (!question.text.empty()) ROS_ERROR("dem_soil: the run is cut short: %s", question.text.c_str());
        hooks_.state("ready");
        break;
      default:
        throw Error(fmt::format("request {} is not known", question.request));
    }
  }

  static boost::shared_ptr<SegmentLoads> answer_to(const SegmentMotion& question) {
    const auto answer = boost::make_shared<SegmentLoads>();
    answer->header.frame_id = "rig";
    answer->run = question.run;
    answer->step = question.step;
    answer->request = question.request;
    return answer;
  }

  void open(const SegmentMotion& question) {
    soil_.reset();
    run_ = question.run;
    step_ = 0;
    link_.meet(settings_.patience);
    const wheel::FlexibleWheel wheel(settings_.model);
    if (question.text != cosim::wheel_fingerprint(wheel))
      throw Error(fmt::format("the wheel has other faces than '{}' here", settings_.model.name));
    soil_.emplace(cosim::soil_under(settings_.model, settings_.soil, hooks_.bed(), settings_.dem, {},
                                    settings_.threads));
    const auto answer = answer_to(question);
    answer->soil = settings_.soil_name;
    answer->settings = settings_.dem.name;
    answer->clearance = cosim::start_clearance(*soil_, wheel);
    answer->time_step = soil_->time_step();
    if (!question.state.empty()) {
      const dem::Archive archive =
          dem::archive_from_bytes(question.state, cosim::checkpoint_kind, "checkpoint");
      cosim::restore_soil(archive, "checkpoint", *soil_);
      step_ = static_cast<std::uint64_t>(archive.get<std::int64_t>("coupling_step").at(0));
    }
    link_.send(answer);
    hooks_.state("running");
  }

  void step(const SegmentMotion& question) {
    if (question.step != step_ + 1)
      throw Error(fmt::format("step {} was asked for, the soil is at step {}", question.step, step_));
    step_ = question.step;
    const std::vector<wheel::SegmentState> segments = from_message(question);
    if (segments.size() != soil_->segment_count())
      throw Error(fmt::format("step {}: {} segments, the soil has the faces of {}", step_, segments.size(),
                              soil_->segment_count()));
    const auto answer = answer_to(question);
    put(soil_->advance(static_cast<std::int64_t>(step_), segments), *answer);
    link_.send(answer);
    hub_x_ = 0.0;
    for (const wheel::SegmentState& segment : segments)
      hub_x_ += segment.position.x() / static_cast<double>(segments.size());
    hooks_.shown(*soil_, hub_x_, false);
  }

  void fail(const SegmentMotion* question, const std::string& why) {
    ROS_ERROR("dem_soil: %s", why.c_str());
    soil_.reset();
    held_ = false;
    hooks_.state("failed: " + why);
    if (question == nullptr) return;
    const auto answer = answer_to(*question);
    answer->failure = why;
    link_.send(answer);
  }

  const CoupledSoilSettings& settings_;
  const CoupledSoilHooks& hooks_;
  Link<SegmentLoads, SegmentMotion> link_;
  std::optional<cosim::DemSoil> soil_;
  std::uint64_t run_ = 0, step_ = 0;
  double hub_x_ = 0.0;
  bool held_ = false;
};

}  // namespace

void serve_coupled_soil(const ros::NodeHandle& node, const CoupledSoilSettings& settings,
                        const CoupledSoilHooks& hooks) {
  Server(node, settings, hooks).serve();
}

}  // namespace wheel_twin::nodes
