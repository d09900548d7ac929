#include "nodes/coupled_soil.h"

#include <fmt/format.h>

#include <optional>

#include "base/error.h"
#include "cosim/checkpoint.h"
#include "cosim/dem_contact.h"
#include "cosim/emergent.h"
#include "effects/acting.h"
#include "nodes/answerer.h"
#include "nodes/coupling_conversion.h"
#include "nodes/patience.h"

namespace wheel_twin::nodes {
namespace {

class Soil final : public Answerer<SegmentMotion, SegmentLoads> {
 public:
  Soil(const ros::NodeHandle& node, const CoupledSoilSettings& settings, const CoupledSoilHooks& hooks)
      : Answerer(node, "soil/segment_loads", "wheel/segments", "flexible_wheel",
                 {"dem_soil", "ready", end_patience(settings.patience), hooks.quit, hooks.state}),
        settings_(settings),
        hooks_(hooks) {}

 private:
  void open(const SegmentMotion& question, SegmentLoads& answer) override {
    step_ = 0;
    hub_x_ = 0.0;
    const wheel::FlexibleWheel wheel(settings_.model);
    if (question.text != cosim::wheel_fingerprint(wheel))
      throw Error(fmt::format("the wheel has other faces than '{}' here", settings_.model.name));
    const effects::Acting acting = effects::read_effects(
        question.effects, [](const rig::Ports& ports) { cosim::refuse_what_emerges(ports.soil); });
    soil_.emplace(cosim::soil_under(settings_.model, settings_.soil, hooks_.bed(), settings_.dem,
                                    acting.ports, settings_.threads));
    answer.soil = settings_.soil_name;
    answer.settings = settings_.dem.name;
    answer.clearance = cosim::start_clearance(*soil_, wheel, acting.ports);
    answer.time_step = soil_->time_step();
    if (question.state.empty()) return;
    const dem::Archive archive =
        dem::archive_from_bytes(question.state, cosim::checkpoint_kind, "checkpoint");
    cosim::restore_soil(archive, "checkpoint", *soil_);
    step_ = static_cast<std::uint64_t>(archive.get<std::int64_t>("coupling_step").at(0));
  }

  void step(const SegmentMotion& question, SegmentLoads& answer) override {
    if (question.step != step_ + 1)
      throw Error(fmt::format("step {} was asked for, the soil is at step {}", question.step, step_));
    step_ = question.step;
    const std::vector<wheel::SegmentState> segments = from_message(question);
    if (segments.size() != soil_->segment_count())
      throw Error(fmt::format("step {}: {} segments, the soil has the faces of {}", step_, segments.size(),
                              soil_->segment_count()));
    put(soil_->advance(static_cast<std::int64_t>(step_), segments), answer);
    hub_x_ = 0.0;
    for (const wheel::SegmentState& segment : segments)
      hub_x_ += segment.position.x() / static_cast<double>(segments.size());
  }

  void checkpoint(const SegmentMotion& /*question*/, SegmentLoads& answer) override {
    answer.state = dem::archive_bytes(cosim::checkpoint_kind, cosim::soil_archive(*soil_));
  }

  void show(bool at_rest) override { hooks_.shown(*soil_, hub_x_, at_rest); }
  void drop(const std::string& /*why*/) override { soil_.reset(); }

  const CoupledSoilSettings& settings_;
  const CoupledSoilHooks& hooks_;
  std::optional<cosim::DemSoil> soil_;
  std::uint64_t step_ = 0;
  double hub_x_ = 0.0;
};

}  // namespace

void serve_coupled_soil(const ros::NodeHandle& node, const CoupledSoilSettings& settings,
                        const CoupledSoilHooks& hooks) {
  Soil(node, settings, hooks).serve();
}

}  // namespace wheel_twin::nodes
