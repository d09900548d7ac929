#include "nodes/coupled_wheel.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "cosim/checkpoint.h"
#include "cosim/coupled_contact.h"
#include "cosim/emergent.h"
#include "effects/acting.h"
#include "nodes/answerer.h"
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

  Answer open(std::uint64_t run, const std::string& fingerprint, const std::vector<std::string>& effects,
              std::vector<std::uint8_t> state) {
    soil_.begin(run, patience_);
    const auto question = soil_.question(SegmentMotion::OPEN);
    question->text = fingerprint;
    question->effects = effects;
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

class Wheel final : public Answerer<HubMotion, HubLoad> {
 public:
  Wheel(const ros::NodeHandle& node, const CoupledWheelSettings& settings, const CoupledWheelHooks& hooks)
      : Answerer(node, "wheel/hub_load", "rig/hub_motion", "virtual_rig",
                 {"flexible_wheel", "waiting", settings.patience, hooks.quit, hooks.status}),
        settings_(settings),
        hooks_(hooks),
        soil_(node, settings, hooks.quit) {}

 private:
  void open(const HubMotion& question, HubLoad& answer) override {
    acting_ = effects::read_effects(question.effects,
                                    [](const rig::Ports& ports) { cosim::refuse_what_emerges(ports.wheel); });
    std::optional<cosim::CouplingState> resumed;
    std::vector<std::uint8_t> state;
    const wheel::FlexibleWheel wheel(settings_.model);
    if (!question.text.empty()) {
      const dem::Archive archive = dem::read_archive(question.text, cosim::checkpoint_kind);
      resumed = cosim::load_coupling(archive, question.text, static_cast<std::size_t>(wheel.segment_count()));
      state = dem::archive_bytes(cosim::checkpoint_kind, archive);
    }
    const auto opened =
        soil_.open(question.run, cosim::wheel_fingerprint(wheel), question.effects, std::move(state));
    contact_ = std::make_unique<cosim::CoupledContact>(settings_.model, soil_, acting_.ports);
    if (resumed) contact_->resume(std::move(*resumed));
    answer.wheel = settings_.model.name;
    answer.soil = opened->soil;
    answer.settings = opened->settings;
    answer.clearance = opened->clearance;
    answer.soil_step = opened->time_step;
  }

  void step(const HubMotion& question, HubLoad& answer) override {
    answer.replayed = contact_->replaying() ? 1 : 0;
    put(contact_->advance(from_message(question)), answer);
  }

  void checkpoint(const HubMotion& question, HubLoad& /*answer*/) override {
    dem::Archive archive = dem::archive_from_bytes(soil_.state(), cosim::checkpoint_kind, question.text);
    cosim::store(contact_->state(), archive);
    dem::write_archive(question.text, cosim::checkpoint_kind, archive);
  }

  void hold() override { soil_.hold(); }

  void show(bool at_rest) override {
    if (!contact_->replaying()) hooks_.shown(contact_->wheel(), at_rest);
  }

  void drop(const std::string& why) override {
    soil_.close(why);
    contact_.reset();
  }

  const CoupledWheelSettings& settings_;
  const CoupledWheelHooks& hooks_;
  RemoteSoil soil_;
  effects::Acting acting_;  // outlives the contact
  std::unique_ptr<cosim::CoupledContact> contact_;
};

}  // namespace

void serve_coupled_wheel(const ros::NodeHandle& node, const CoupledWheelSettings& settings,
                         const CoupledWheelHooks& hooks) {
  hooks.status("waiting");
  Wheel(node, settings, hooks).serve();
}

}  // namespace wheel_twin::nodes
