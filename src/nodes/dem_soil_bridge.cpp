#include "nodes/dem_soil_bridge.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <fmt/format.h>
#include <ros/console.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <ros/this_node.h>
#include <ros/timer.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/config_path.h"
#include "base/error.h"
#include "cosim/dem_settings.h"
#include "cosim/grains.h"
#include "dem/bed.h"
#include "nodes/coupled_soil.h"
#include "nodes/link.h"
#include "nodes/params.h"
#include "nodes/soil_conversion.h"
#include "wheel/wheel_model.h"

namespace wheel_twin::nodes {
namespace {

constexpr double fastest_rate =
    2.0;  // Hz: rviz draws 75,000 points 10 to 17 times a second, topics carry 2 MB each

struct Settings {
  std::string soil;
  std::optional<wheel::WheelModel> wheel;  // whose soil this is; none: a bed by itself
  cosim::DemSettings dem;                  // of the wheel's soil
  dem::BedSettings bed;
  int threads = 1;
  double patience = 30.0;  // s
  std::string save_path;
  std::string frame;
  double rate = 1.0;
  double rut_half_width = 0.03;
  bool prepare_at_start = true;
};

Settings read_settings(const ros::NodeHandle& node) {
  Params params = params_of(node);
  Settings s;
  s.soil = params.text("soil", "mars_simulant");
  if (const std::string wheel = params.text("wheel", ""); !wheel.empty()) {
    s.wheel = wheel::read_wheel_file(find_config("wheels", wheel));
    s.dem = cosim::load_dem_settings(params.text("dem", "paper"));
    s.bed = s.dem.bed;
    s.patience = params.number("patience", s.patience, {0.1, 1.0e4});
  }
  s.bed.length = params.number("length", s.bed.length, {0.03, 10.0});
  s.bed.width = params.number("width", s.bed.width, {0.03, 10.0});
  s.bed.depth = params.number("depth", s.bed.depth, {0.02, 2.0});
  s.bed.seed = static_cast<std::uint64_t>(params.integer("seed", 1, 0, 1000000000));
  if (const auto friction = params.optional_number("fill_friction", {0.0, 10.0}))
    s.bed.fill_friction = friction;
  s.threads = params.integer("threads", 1, 1, 64);
  s.save_path = params.absolute_path("save_path");
  s.frame = params.text("frame_id", "rig");
  s.rate = params.number("publish_rate", 1.0, {0.01, fastest_rate});
  s.rut_half_width = params.number("rut_half_width", 0.03, {0.001, 1.0});
  s.prepare_at_start = params.boolean("prepare_at_start", true);
  params.finish();
  s.dem.bed = s.bed;
  return s;
}

dem::GranularSoil granular_soil(const Settings& settings) {
  dem::GranularSoil soil = dem::load_granular_soil(settings.soil);
  return settings.wheel ? cosim::scaled_soil(std::move(soil), settings.dem) : soil;
}

}  // namespace

class DemSoilBridge::Impl {
 public:
  Impl(ros::NodeHandle node, const ros::NodeHandle& private_node)
      : settings_(read_settings(private_node)),
        soil_(granular_soil(settings_)),
        node_(std::move(node)),
        updater_(node_, private_node, ros::this_node::getName()) {
    cloud_ = node_.advertise<sensor_msgs::PointCloud2>("soil/cloud", 1, true);
    heights_ = node_.advertise<sensor_msgs::PointCloud2>("soil/height_map", 1, true);
    rut_ = node_.advertise<visualization_msgs::Marker>("soil/rut", 1, true);
    state_topic_ = node_.advertise<std_msgs::String>("soil/state", 1, true);
    prepare_ = node_.advertiseService("soil/prepare", &Impl::on_prepare, this);
    save_ = node_.advertiseService("soil/save", &Impl::on_save, this);
    updater_.setHardwareID("discrete-element soil");
    updater_.add("soil bed", this, &Impl::diagnose);
    set_state("empty");
    timer_ =
        node_.createTimer(ros::Duration(1.0 / settings_.rate), [this](const ros::TimerEvent&) { publish(); });
    if (settings_.prepare_at_start || settings_.wheel) start_preparing();
    if (settings_.wheel) server_ = std::thread([this] { serve_wheel(); });
  }

  ~Impl() {
    timer_.stop();
    quit_ = true;
    if (server_.joinable()) server_.join();
    if (worker_.joinable()) worker_.join();
  }

 private:
  void set_state(const std::string& state) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      state_ = state;
    }
    std_msgs::String message;
    message.data = state;
    state_topic_.publish(message);
  }

  std::string state() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return state_;
  }

  void start_preparing() {
    if (worker_.joinable()) worker_.join();
    set_state("preparing");
    worker_ = std::thread([this] {
      try {
        dem::Bed bed = dem::fetch_bed(soil_, settings_.bed, settings_.threads);
        dem::System system = bed_system(soil_, bed, 0.05, settings_.threads);
        {
          const std::lock_guard<std::mutex> lock(mutex_);
          bed_ = std::move(bed);
          system_.emplace(std::move(system));
        }
        prepared_.notify_all();
        set_state("ready");
      } catch (const std::exception& error) {
        ROS_ERROR("%s", error.what());
        set_state(std::string("failed: ") + error.what());
      }
    });
  }

  bool on_prepare(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    response.success = state() != "preparing" && !settings_.wheel;
    response.message = settings_.wheel    ? "a wheel's bed is prepared when the node starts"
                       : response.success ? "preparing"
                                          : "already preparing";
    if (response.success) start_preparing();
    return true;
  }

  bool on_save(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex_);
    try {
      if (!bed_) throw Error("there is no bed to save: prepare one first");
      if (settings_.save_path.empty()) throw Error("parameter save_path is not set");
      dem::write_bed(settings_.save_path, *bed_, dem::bed_description(soil_, settings_.bed));
      response.success = 1;
      response.message = settings_.save_path;
    } catch (const std::exception& error) {
      response.success = 0;
      response.message = error.what();
    }
    return true;
  }

  /// The soil of a wheel in another node.
  void serve_wheel() {
    CoupledSoilHooks hooks;
    hooks.quit = [this] { return quit_.load(); };
    hooks.state = [this](const std::string& state) { set_state(state); };
    hooks.bed = [this]() -> const dem::Bed& { return settled_bed(); };
    hooks.shown = [this](const cosim::DemSoil& soil, double hub_x, bool at_rest) {
      const ros::WallTime now = ros::WallTime::now();
      if (now < due_ && !at_rest) return;
      due_ = now + ros::WallDuration(1.0 / settings_.rate);
      const dem::BedSettings& b = settings_.bed;
      show(
          soil.system(), [&] { return cosim::spheres_about(soil, hub_x); },
          b.periodic_x ? hub_x - 0.5 * b.length : -settings_.dem.start_x, at_rest);
    };
    serve_coupled_soil(
        node_, {*settings_.wheel, soil_, soil_.name, settings_.dem, settings_.threads, settings_.patience},
        hooks);
  }

  /// Waits for the bed, which does not change any more; from now on only the wheel's soil is shown.
  const dem::Bed& settled_bed() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!bed_) {
      if (quit_ || !ros::ok()) throw NodeEnds{};
      if (state_.rfind("failed", 0) == 0) throw Error(state_);
      prepared_.wait_for(lock, std::chrono::milliseconds(100));
    }
    system_.reset();
    return *bed_;
  }

  void publish() {
    updater_.update();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!system_) return;
    const double begin = settings_.wheel ? -settings_.dem.start_x : 0.0;
    const auto spheres = [&] {
      std::vector<dem::SphereState> moved = system_->spheres();
      for (dem::SphereState& sphere : moved) sphere.center.x() += begin;
      return moved;
    };
    show(*system_, spheres, begin, false);
  }

  /// `spheres`: those of `system` in frame `rig`, along x from `begin` on. `everything`: also for viewers
  /// that come later.
  void show(const dem::System& system, const std::function<std::vector<dem::SphereState>()>& spheres,
            double begin, bool everything) {
    const bool cloud = everything || cloud_.getNumSubscribers() > 0;
    const bool surface = everything || heights_.getNumSubscribers() > 0 || rut_.getNumSubscribers() > 0;
    if (!cloud && !surface) return;
    std_msgs::Header header;
    header.stamp = ros::Time::now();
    header.frame_id = settings_.frame;
    const std::vector<dem::SphereState> placed = spheres();
    if (cloud) cloud_.publish(soil_cloud(system, placed, header));
    if (!surface) return;
    const dem::BedSettings& b = settings_.bed;
    const dem::HeightMap map = height_map(
        placed, {{begin, -0.5 * b.width, -b.depth}, {begin + b.length, 0.5 * b.width, 1.0}}, 0.003);
    heights_.publish(height_cloud(map, header));
    rut_.publish(rut_profile(map, settings_.rut_half_width, header));
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool failed = state_.rfind("failed", 0) == 0;
    status.summary(failed ? diagnostic_msgs::DiagnosticStatus::ERROR : diagnostic_msgs::DiagnosticStatus::OK,
                   state_);
    if (!bed_) return;
    status.add("clumps", bed_->report.clumps);
    status.add("spheres", bed_->report.spheres);
    status.add("packing density", bed_->report.packing_density);
    status.add("kinetic energy (J)", bed_->report.kinetic_energy);
  }

  Settings settings_;
  dem::GranularSoil soil_;
  ros::NodeHandle node_;
  mutable std::mutex mutex_;
  std::string state_;
  std::optional<dem::Bed> bed_;
  std::optional<dem::System> system_;
  diagnostic_updater::Updater updater_;
  ros::Publisher cloud_, heights_, rut_, state_topic_;
  ros::ServiceServer prepare_, save_;
  ros::Timer timer_;
  std::thread worker_;
  // The soil of a wheel.
  std::atomic<bool> quit_{false};
  std::condition_variable prepared_;
  ros::WallTime due_;
  std::thread server_;
};

DemSoilBridge::DemSoilBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : impl_(std::make_unique<Impl>(node, private_node)) {}

DemSoilBridge::~DemSoilBridge() = default;

}  // namespace wheel_twin::nodes
