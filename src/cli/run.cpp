#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/atomic_file.h"
#include "base/config_path.h"
#include "base/error.h"
#include "base/progress.h"
#include "cli/commands.h"
#include "cosim/emergent.h"
#include "cosim/frame.h"
#include "effects/acting.h"
#include "logs/bag_writer.h"
#include "logs/experiment.h"
#include "twin/dem_rig.h"
#include "twin/virtual_rig.h"

namespace wheel_twin::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double degree = 3.14159265358979323846 / 180.0;

struct Options {
  twin::VirtualRigNames names;
  std::string fidelity = "semi_empirical";
  std::string experiment;
  std::string out;
  rig::RunConditions conditions;
  rig::RunProfile profile;
  double steering_degrees = 0.0;
  double epoch = 1.7e9;
  std::uint64_t seed = 1;
  std::vector<std::string> effects;
  // Fidelity dem.
  std::string dem = "paper";
  std::uint64_t bed_seed = 1;
  int threads = 2;
  bool resume = false;
  std::string frames;
  double frame_interval = 0.05;
  bool dwell_given = false;
  bool duration_given = false;
};

Json summary_of(const Options& options, const rig::RunSettings& run, const twin::VirtualRig& loaded,
                const rig::RunSummary& summary, const std::string& bag) {
  const rig::RunConditions& set = run.conditions;
  return {{"schema", 1},
          {"bag", bag},
          {"wheel", loaded.wheel.name},
          {"soil", loaded.soil.name},
          {"rig", run.rig.name},
          {"sensors", {run.sensors.ft.name, run.sensors.draw_wire.name}},
          {"fidelity", options.fidelity},
          {"effects", options.effects},
          {"seed", run.seed},
          {"conditions",
           {{"slip", set.slip},
            {"load_n", set.load},
            {"wheel_speed_rad_s", set.wheel_speed},
            {"steering_angle_rad", set.steering_angle},
            {"towed", set.towed},
            {"temperature_c", set.temperature},
            {"temperature_rate_k_s", set.temperature_rate}}},
          {"window_s", {summary.window[0], summary.window[1]}},
          {"mean",
           {{"drawbar_pull_n", summary.drawbar_pull},
            {"side_force_n", summary.side_force},
            {"normal_load_n", summary.normal_load},
            {"hub_displacement_m", summary.hub_displacement},
            {"drive_torque_nm", summary.drive_torque},
            {"motor_effort_nm", summary.motor_effort},
            {"slip", summary.slip}}}};
}

/// The co-simulated side of a run: contact, checkpoints, and what it cost.
class DemRun {
 public:
  DemRun(const Options& options, const std::string& wheel, const std::string& soil, const rig::Ports& ports,
         const std::string& bag)
      : settings_(cosim::load_dem_settings(options.dem)), checkpoint_(bag + ".checkpoint") {
    settings_.bed.seed = options.bed_seed;
    if (!options.frames.empty()) fs::create_directories(options.frames);
    contact_ = twin::make_dem_contact({wheel, soil, options.dem}, settings_, ports, options.threads);
    if (!options.resume) return;
    if (!fs::exists(checkpoint_))
      throw Error(fmt::format("{}: there is no checkpoint to resume from", checkpoint_));
    contact_->resume(checkpoint_);
  }

  rig::Contact& contact() { return *contact_; }

  /// The settings' course of the run, but for what the command line says.
  void set_profile(const Options& options, rig::RunProfile& profile) const {
    const rig::RunProfile asked = profile;
    profile = settings_.profile;
    profile.clearance = contact_->clearance();
    if (options.dwell_given) profile.dwell = asked.dwell;
    if (options.duration_given) profile.longest_steady = asked.longest_steady;
    if (asked.travel != rig::RunProfile{}.travel) profile.travel = asked.travel;
  }

  /// A checkpoint a minute, and a picture's data when one is due.
  void update(const Options& options, const rig::RigStep& step) {
    if (!options.frames.empty() && !contact_->coupled().replaying() && step.state.time >= next_frame_) {
      const auto number = std::lround(step.state.time / options.frame_interval);
      next_frame_ = (static_cast<double>(number) + 0.999) * options.frame_interval;
      cosim::write_frame((fs::path(options.frames) / fmt::format("frame_{:06}.h5", number)).string(),
                         *contact_, step);
    }
    const auto now = std::chrono::steady_clock::now();
    if (contact_->coupled().replaying() || now - written_ < std::chrono::minutes(1)) return;
    contact_->write_checkpoint(checkpoint_);
    written_ = now;
  }

  void finish() const {
    std::error_code ignored;
    fs::remove(checkpoint_, ignored);
  }

  Json report(double wall) const {
    const cosim::CouplingCost cost = contact_->coupled().cost();
    const dem::System& system = contact_->soil().system();
    const dem::Statistics soil = system.statistics();
    const dem::BedReport& bed = contact_->bed_report();
    return {{"settings", settings_.name},
            {"bed_seed", settings_.bed.seed},
            {"bed_m", {settings_.bed.length, settings_.bed.width, settings_.bed.depth}},
            {"clumps", system.size()},
            {"spheres", system.sphere_count()},
            {"packing_density", bed.packing_density},
            {"time_step_s", system.time_step()},
            {"rayleigh_fraction", system.time_step() / system.rayleigh_step()},
            {"threads", system.settings().threads},
            {"steps", cost.steps},
            {"sphere_updates_per_s",
             static_cast<double>(cost.steps) * static_cast<double>(system.sphere_count()) / wall},
            {"memory_bytes", soil.memory_bytes},
            {"seconds",
             {{"wall", wall},
              {"wheel", cost.wheel},
              {"soil", cost.soil},
              {"soil_contacts", soil.seconds_contacts - soil.seconds_walls},
              {"soil_wheel_contact", soil.seconds_walls},
              {"soil_motion", soil.seconds_motion},
              {"soil_lists", soil.seconds_lists}}}};
  }

 private:
  cosim::DemSettings settings_;
  std::string checkpoint_;
  std::unique_ptr<cosim::DemContact> contact_;
  double next_frame_ = 0.0;  // s of the run
  std::chrono::steady_clock::time_point written_ = std::chrono::steady_clock::now();
};

/// One run: its bag at `bag` and the summary beside it.
void run_once(const Options& options, const twin::VirtualRig& loaded, rig::RunSettings settings,
              const rig::Ports& ports, const std::string& bag) {
  std::unique_ptr<DemRun> dem;
  std::unique_ptr<rig::Contact> fast;
  if (options.fidelity == "dem") {
    dem = std::make_unique<DemRun>(options, loaded.wheel_name, loaded.soil_name, ports, bag);
    dem->set_profile(options, settings.profile);
  } else {
    fast = twin::make_contact(options.fidelity, loaded.wheel, loaded.soil, ports);
  }
  const auto begin = std::chrono::steady_clock::now();
  rig::FreeRun run(settings, dem ? dem->contact() : *fast, ports);
  Progress progress(fs::path(bag).filename().string(), run.expected_end());
  rig::RunSummary summary;
  const run_log::RunLog log = rig::run_to_end(run, summary, {[&](const rig::RigStep& step) {
                                                progress.update(step.state.time);
                                                if (dem) dem->update(options, step);
                                              }});
  logs::write_bag(log, bag);
  fs::path json = bag;
  json.replace_extension(".json");
  Json result = summary_of(options, settings, loaded, summary, fs::path(bag).filename().string());
  if (dem)
    result["dem"] =
        dem->report(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  write_file(json.string(), result.dump(2) + "\n");
  if (dem) dem->finish();
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print(
      "{}: slip {:.3f}, load {:.1f} N: drawbar pull {:.2f} N, side force {:.2f} N, normal load {:.2f} N, hub "
      "{:.2f} mm "
      "down, drive torque {:.3f} N m (means from {:.1f} to {:.1f} s)\n",
      bag, std::abs(summary.slip) < 5e-4 ? 0.0 : summary.slip, settings.conditions.load, summary.drawbar_pull,
      summary.side_force, summary.normal_load, 1e3 * summary.hub_displacement, summary.drive_torque,
      summary.window[0], summary.window[1]);
  fmt::print("{:.1f} s simulated and written in {:.2f} s\n", run.time(), wall);
}

rig::RunSettings settings_of(const Options& options, const twin::VirtualRig& loaded) {
  rig::RunSettings settings = loaded.run;
  settings.profile = options.profile;
  settings.conditions = options.conditions;
  settings.conditions.steering_angle = options.steering_degrees * degree;
  settings.seed = options.seed;
  settings.epoch = options.epoch;
  return settings;
}

/// Speed that the faster of rim and carriage has, over the radius, rad/s: that of the wheel unless it brakes.
/// A locked wheel does not tell how fast the carriage went: `otherwise`.
double faster_speed(const logs::Run& run, double otherwise) {
  if (run.slip >= 0.0) return run.wheel_speed;
  return run.slip > -1.0 && run.wheel_speed != 0.0 ? run.wheel_speed / (1.0 + run.slip) : otherwise;
}

/// Every run of an experiment, with its declared conditions, into the directory `out`.
void run_experiment(const Options& options, const rig::Ports& ports) {
  const bool is_name = !fs::exists(options.experiment);
  logs::Experiment experiment = logs::read_experiment(
      is_name ? find_config("experiments", options.experiment) : options.experiment, logs::Stage::planned);
  twin::VirtualRig loaded = twin::load_virtual_rig(options.names);
  loaded.wheel = experiment.wheel;
  loaded.soil = experiment.soil;
  loaded.wheel_name = experiment.wheel.name;
  loaded.soil_name = experiment.soil.name;
  loaded.run.radius = experiment.wheel.radius;
  auto& ft = loaded.run.sensors.ft;
  if (experiment.ft) {
    ft.rate = experiment.ft->rate;
    ft.noise.head<3>().setConstant(experiment.ft->noise);
    ft.resolution.head<3>().setConstant(experiment.ft->resolution);
  }
  experiment.ft = logs::DeclaredSensor{ft.rate, ft.noise[0], ft.resolution[0]};
  auto& wire = loaded.run.sensors.draw_wire;
  if (experiment.draw_wire) {
    wire.rate = experiment.draw_wire->rate;
    wire.noise = experiment.draw_wire->noise;
    wire.resolution = experiment.draw_wire->resolution;
  }
  experiment.draw_wire = logs::DeclaredSensor{wire.rate, wire.noise, wire.resolution};
  experiment.plate_tests.clear();
  experiment.direct_shear.clear();
  fs::create_directories(options.out);
  for (std::size_t i = 0; i < experiment.runs.size(); ++i) {
    logs::Run& run = experiment.runs[i];
    run.averages.reset();
    if (!run.bag) run.bag = fmt::format("run_{:03}.bag", i);
    rig::RunSettings settings = settings_of(options, loaded);
    settings.conditions.slip = run.slip;
    settings.conditions.load = run.load;
    settings.conditions.wheel_speed = faster_speed(run, options.conditions.wheel_speed);
    settings.conditions.steering_angle = run.steering_angle;
    settings.seed = options.seed + i;
    settings.epoch = options.epoch + 300.0 * static_cast<double>(i);
    const bool reference = run.role == logs::Role::reference;  // the rig known to be in order
    run_once(options, loaded, settings, reference ? rig::Ports{} : ports,
             (fs::path(options.out) / *run.bag).string());
  }
  logs::write_experiment(experiment, options.out);
}

void run(const Options& options) {
  const effects::Acting acting = effects::read_effects(options.effects, [&](const rig::Ports& ports) {
    if (options.fidelity != "dem") return;
    cosim::refuse_what_emerges(ports.soil);
    cosim::refuse_what_emerges(ports.wheel);
  });
  if (!options.experiment.empty()) {
    run_experiment(options, acting.ports);
    return;
  }
  const twin::VirtualRig loaded = twin::load_virtual_rig(options.names);
  if (fs::path(options.out).extension() != ".bag")
    throw Error(fmt::format("{}: --out must end in .bag", options.out));
  run_once(options, loaded, settings_of(options, loaded), acting.ports, options.out);
}

}  // namespace

void add_run(CLI::App& app) {
  auto* command =
      app.add_subcommand("run", "One virtual run, or all runs of an experiment, as the rig's logs.");
  command->footer(
      "Example: twin run --wheel amalia --soil mars_simulant --slip 0.3 --load 42.1 --out run.bag\n"
      "         twin run --experiment paper_single_wheel --out out/paper\n"
      "         twin run --fidelity dem --dem quick --slip 0.5 --out quick.bag");
  auto options = std::make_shared<Options>();
  const auto add = [&](const char* name, auto& value, const char* help) {
    return command->add_option(name, value, help)->capture_default_str();
  };
  auto& set = *options;
  add("--wheel", set.names.wheel, "Wheel: a name in config/wheels or a file");
  add("--soil", set.names.soil, "Soil: a name in config/soils or a file");
  add("--rig", set.names.rig, "Rig: a name in config/rigs or a file");
  add("--ft", set.names.ft, "Force/torque sensor: a name in config/sensors or a file");
  add("--draw-wire", set.names.draw_wire, "Draw-wire sensor: a name in config/sensors or a file");
  add("--joints", set.names.joints, "Motor encoders: a name in config/sensors or a file");
  add("--fidelity", set.fidelity, "Soil: semi_empirical or dem");
  add("--slip", set.conditions.slip,
      "-1 (locked) to 1; the faster of rim and carriage runs at the wheel speed");
  add("--load", set.conditions.load, "Force the soil carries at rest, N");
  add("--wheel-speed", set.conditions.wheel_speed, "rad/s; of an experiment: for its locked wheels");
  add("--steering", set.steering_degrees, "Steering angle, degrees, to the left when positive");
  command->add_flag("--towed", set.conditions.towed, "Drive uncoupled, the carriage pulls the wheel");
  add("--temperature", set.conditions.temperature, "degrees C");
  add("--temperature-rate", set.conditions.temperature_rate, "Warming of the sensor during the run, K/s");
  add("--travel", set.profile.travel, "Carriage travel of the steady part, m; 0: by duration alone");
  auto* duration = add("--duration", set.profile.longest_steady, "Longest steady part, s");
  auto* dwell = add("--dwell", set.profile.dwell, "At rest on the soil before the start, s");
  add("--effect", set.effects,
      "Acts on the run (of an experiment: on all but reference runs), as name:parameter=value,...; may be "
      "repeated");
  add("--seed", set.seed, "Seed of all noise: the same seed gives the same bytes");
  add("--epoch", set.epoch, "ROS time of the start, s");
  add("--experiment", set.experiment, "Experiment: a name in config/experiments, a file or a directory");
  command->add_option("--out", set.out, "Bag of the run, or directory of the experiment")->required();
  add("--dem", set.dem,
      "Fidelity dem: bed, grains and course of the run: a name in config/dem (paper, quick) or a file");
  add("--bed-seed", set.bed_seed, "Fidelity dem: another seed, another bed");
  add("--threads", set.threads, "Fidelity dem: threads of the soil")->check(CLI::Range(1, 64));
  add("--frames", set.frames, "Fidelity dem: folder for what scripts/film draws");
  add("--frame-interval", set.frame_interval, "Simulated time from one frame to the next, s")
      ->check(CLI::Range(0.001, 1000.0));
  command->add_flag(
      "--resume", set.resume,
      "Fidelity dem: go on from the checkpoint beside the bag, which a run writes every minute");
  command->callback([options, dwell, duration] {
    options->dwell_given = dwell->count() > 0;
    options->duration_given = duration->count() > 0;
    run(*options);
  });
}

}  // namespace wheel_twin::cli
