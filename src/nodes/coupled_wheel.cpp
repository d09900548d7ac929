#include "nodes/coupled_wheel.h"

#include <fmt/format.h>
#include <ros/console.h>

#include <memory>
#include <utility>

#include "base/error.h"
#include "cosim/checkpoint.h"
#include "cosim/coupled_contact.h"
#include "nodes/asker.h"
#include "nodes/coupling_conversion.h"
#include "nodes/patience.h"

namespace wheel_twin::nodes {
namespace {

/// The soil in another node.
class RemoteSoil final : public cosim::SoilSide {
 public:
  using Answer = boost::shared_ptr<const SegmentLoads>;

  RemoteSoil(const ros::NodeHandle& node, const CoupledWheelSettings& settings, std::function<bool()> quit)
      : soil_(node, "wheel/segments", "soil/segment_loads", "dem_soil", "dem_soil: ", std::move(quit)),
        patience_(settings.patience) {}

  Answer open(std::uint64_t run, const std::string& fingerprint, std::vector<std::uint8_t> state) {
    soil_.begin(run, patience_);
    const auto question = soil_.question(SegmentMotion::OPEN);
    question->text = fingerprint;
    question->state = std::move(state);
    const Answer answer = soil_.ask(question, bed_patience(patience_));
    time_step_ = answer->time_step;
    return answer;
  }

  double time_step() const override { return time_step_; }

  const std::vector<wheel::Wrench>& advance(std::int64_t step,
                                            const std::vector<wheel::SegmentState>& segments) override {
    soil_.set_step(static_cast<std::uint64_t>(step));
    const auto question = soil_.question(SegmentMotion::STEP);
    put(segments, *question);
    const Answer answer = soil_.ask(question, patience_);
    if (answer->segments.size() != segments.size())
      throw Error(fmt::format("dem_soil answered loads on {} segments, the wheel has {}",
                              answer->segments.size(), segments.size()));
    loads_ = from_message(*answer);
    return loads_;
  }

  std::vector<std::uint8_t> state() {
    return soil_.ask(soil_.question(SegmentMotion::CHECKPOINT), patience_)->state;
  }

  void hold() { soil_.hold(); }
  void close(const std::string& why) { soil_.close(why); }

 private:
  Asker<SegmentMotion, SegmentLoads> soil_;
  double patience_;
  double time_step_ = 0.0;
  std::vector<wheel::Wrench> loads_;
};

class Server {
 public:
  Server(const ros::NodeHandle& node, const CoupledWheelSettings& settings, const CoupledWheelHooks& hooks)
      : settings_(settings),
        hooks_(hooks),
        rig_(node, "wheel/hub_load", "rig/hub_motion", "virtual_rig", hooks.quit),
        soil_(node, settings, hooks.quit) {}

  void serve() {
    hooks_.status("waiting");
    for (;;) {
      boost::shared_ptr<const HubMotion> question;
      try {
        question = contact_ && !held_ ? rig_.receive(settings_.patience) : rig_.receive_any();
        if (question->request != HubMotion::OPEN && (!contact_ || question->run != run_)) continue;
        held_ = question->request == HubMotion::HOLD;
        take(*question);
      } catch (const NodeEnds&) {
        soil_.close("flexible_wheel ends");
        return;
      } catch (const std::exception& error) {
        fail(question.get(), error.what());
      }
    }
  }

 private:
  void take(const HubMotion& question) {
    switch (question.request) {
      case HubMotion::OPEN:
        open(question);
        break;
      case HubMotion::STEP:
        step(question);
        break;
      case HubMotion::CHECKPOINT:
        write_checkpoint(question);
        break;
      case HubMotion::HOLD:
        soil_.hold();
        hooks_.shown(contact_->wheel(), true);
        break;
      case HubMotion::CLOSE:
        close(question.text);
        break;
      default:
        throw Error(fmt::format("request {} is not known", question.request));
    }
  }

  boost::shared_ptr<HubLoad> answer_to(const HubMotion& question) const {
    const auto answer = boost::make_shared<HubLoad>();
    answer->header.frame_id = "rig";
    answer->run = question.run;
    answer->step = question.step;
    answer->request = question.request;
    return answer;
  }

  void open(const HubMotion& question) {
    close("another run begins");
    run_ = question.run;
    rig_.meet(settings_.patience);
    std::optional<cosim::CouplingState> resumed;
    std::vector<std::uint8_t> state;
    const wheel::FlexibleWheel wheel(settings_.model);
    if (!question.text.empty()) {
      const dem::Archive archive = dem::read_archive(question.text, cosim::checkpoint_kind);
      resumed = cosim::load_coupling(archive, question.text, static_cast<std::size_t>(wheel.segment_count()));
      state = dem::archive_bytes(cosim::checkpoint_kind, archive);
    }
    const auto opened = soil_.open(run_, cosim::wheel_fingerprint(wheel), std::move(state));
    contact_ = std::make_unique<cosim::CoupledContact>(settings_.model, soil_);
    if (resumed) contact_->resume(std::move(*resumed));
    const auto answer = answer_to(question);
    answer->wheel = settings_.model.name;
    answer->soil = opened->soil;
    answer->settings = opened->settings;
    answer->clearance = opened->clearance;
    answer->soil_step = opened->time_step;
    rig_.send(answer);
    hooks_.status("running");
  }

  void step(const HubMotion& question) {
    const auto answer = answer_to(question);
    answer->replayed = contact_->replaying() ? 1 : 0;
    put(contact_->advance(from_message(question)), *answer);
    rig_.send(answer);
    if (answer->replayed == 0) hooks_.shown(contact_->wheel(), false);
  }

  void write_checkpoint(const HubMotion& question) {
    dem::Archive archive = dem::archive_from_bytes(soil_.state(), cosim::checkpoint_kind, question.text);
    cosim::store(contact_->state(), archive);
    dem::write_archive(question.text, cosim::checkpoint_kind, archive);
    rig_.send(answer_to(question));
  }

  void close(const std::string& why) {
    soil_.close(why);
    if (!contact_) return;
    hooks_.shown(contact_->wheel(), true);
    contact_.reset();
    if (!why.empty()) ROS_ERROR("flexible_wheel: the run is cut short: %s", why.c_str());
    hooks_.status("waiting");
  }

  /// One line here, the same reason to both sides.
  void fail(const HubMotion* question, const std::string& why) {
    ROS_ERROR("flexible_wheel: %s", why.c_str());
    soil_.close(why);
    contact_.reset();
    held_ = false;
    hooks_.status("failed: " + why);
    if (question == nullptr) return;
    const auto answer = answer_to(*question);
    answer->failure = why;
    rig_.send(answer);
  }

  const CoupledWheelSettings& settings_;
  const CoupledWheelHooks& hooks_;
  Link<HubLoad, HubMotion> rig_;
  RemoteSoil soil_;
  std::unique_ptr<cosim::CoupledContact> contact_;
  std::uint64_t run_ = 0;
  bool held_ = false;
};

}  // namespace

void serve_coupled_wheel(const ros::NodeHandle& node, const CoupledWheelSettings& settings,
                         const CoupledWheelHooks& hooks) {
  Server(node, settings, hooks).serve();
}

}  // namespace wheel_twin::nodes
