#include "nodes/virtual_rig_bridge.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <fmt/format.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <ros/this_node.h>
#include <rosgraph_msgs/Clock.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "effects/acting.h"
#include "nodes/live_run.h"
#include "nodes/msg_conversion.h"
#include "nodes/pacer.h"
#include "nodes/params.h"
#include "nodes/remote_wheel.h"
#include "nodes/rig_setup.h"
#include "nodes/rig_view.h"

namespace wheel_twin::nodes {
namespace {

constexpr int queue = 4000;           // messages a topic keeps for a slow subscriber: 4 s of a 1 kHz sensor
constexpr double piece_wall = 0.005;  // wall s between publications
constexpr double patience = 0.02;     // wall s that one piece may take

struct Settings {
  RigSetup setup;
  std::vector<std::string> effects;
  std::string bag;
  std::string frame;
  double real_time_factor = 1.0;
  double hold_at_travel = 0.0;
  bool autostart = true;
  bool publish_clock = false;
  // Fidelity dem.
  std::string checkpoint;             // empty: beside the bag, or none without a bag
  double checkpoint_interval = 60.0;  // wall s
  bool resume = false;
  double patience = 30.0;  // s
};

Settings read_settings(const ros::NodeHandle& node) {
  Params params = params_of(node);
  Settings s;
  s.setup = read_rig_setup(params);
  s.effects = params.words("effects");
  s.bag = params.absolute_path("bag");
  s.frame = params.text("frame_id", "ft_sensor");
  s.real_time_factor = params.number("real_time_factor", 1.0, {0.0, 1e6});
  s.hold_at_travel = params.number("hold_at_travel", 0.0, {0.0, 10.0});
  s.autostart = params.boolean("autostart", true);
  s.publish_clock = params.boolean("publish_clock", false);
  s.checkpoint = params.absolute_path("checkpoint");
  s.checkpoint_interval = params.number("checkpoint_interval", s.checkpoint_interval, {0.1, 1e6});
  s.resume = params.boolean("resume", false);
  s.patience = params.number("patience", s.patience, {0.1, 1e4});
  params.finish();
  if (s.checkpoint.empty() && !s.bag.empty()) s.checkpoint = s.bag + ".checkpoint";
  return s;
}

/// Says from time to time how far a long run is and how long it will take.
class RunProgress {
 public:
  /// `time` and `end` of the run, s. `replaying`: what is known already passes quickly.
  void update(double time, double end, bool replaying) {
    const ros::WallTime now = ros::WallTime::now();
    if (begin_.isZero() || replaying) {
      begin_ = said_ = now;
      first_ = time;
    }
    if (time > first_) left_ = (now - begin_).toSec() * std::max(0.0, end - time) / (time - first_);
    if ((now - said_).toSec() < period) return;
    said_ = now;
    ROS_INFO("virtual_rig: %.2f of %.2f s simulated, %.1f min left", time, end, left_ / 60.0);
  }
  double left() const { return left_; }  ///< wall s

 private:
  static constexpr double period = 30.0;  // wall s
  ros::WallTime begin_, said_;
  double first_ = 0.0, left_ = 0.0;
};

}  // namespace

class VirtualRigBridge::Impl {
 public:
  Impl(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
      : settings_(read_settings(private_node)),
        acting_(effects::read_effects(settings_.effects)),
        node_(node),
        pacer_(settings_.real_time_factor),
        view_(node, settings_.setup.wheel, settings_.setup.soil, "rig/labels", !settings_.setup.dem),
        updater_(node, private_node, ros::this_node::getName()),
        want_run_(settings_.autostart) {
    wrench_ = node_.advertise<geometry_msgs::WrenchStamped>("ft_sensor/wrench", queue);
    displacement_ = node_.advertise<DisplacementStamped>("draw_wire/displacement", queue);
    joints_ = node_.advertise<sensor_msgs::JointState>("rig/joint_states", queue);
    temperature_ = node_.advertise<sensor_msgs::Temperature>("rig/temperature", 100);
    status_ = node_.advertise<std_msgs::String>("rig/status", 10, true);
    if (settings_.publish_clock) clock_ = node_.advertise<rosgraph_msgs::Clock>("/clock", 10);
    start_ = node_.advertiseService("rig/start", &Impl::on_start, this);
    stop_ = node_.advertiseService("rig/stop", &Impl::on_stop, this);
    bias_ = node_.advertiseService("ft_sensor/bias", &Impl::on_bias, this);
    updater_.setHardwareID(settings_.setup.run.rig.name);
    updater_.add("virtual rig", this, &Impl::diagnose);
    timer_ = node_.createWallTimer(ros::WallDuration(1.0),
                                   [this](const ros::WallTimerEvent&) { updater_.force_update(); });
    if (settings_.setup.dem)
      remote_ = std::make_unique<RemoteWheel>(node_, settings_.patience, [this] { return quit_.load(); });
    set_status("idle");
    worker_ = std::thread([this] { work(); });
  }

  ~Impl() {
    timer_.stop();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      quit_ = true;
    }
    pacer_.interrupt();
    wake_.notify_all();
    worker_.join();
  }

 private:
  using Trigger = std_srvs::Trigger;

  bool on_start(Trigger::Request&, Trigger::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex_);
    response.success = !running_ || held_;
    response.message = !running_ ? "run started" : held_ ? "run goes on" : "a run is going on";
    if (!response.success) return true;
    want_run_ = true;
    wake_.notify_all();
    return true;
  }

  bool on_stop(Trigger::Request&, Trigger::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex_);
    response.success = running_;
    response.message = running_ ? "ramping down" : "no run is going on";
    if (running_) want_stop_ = want_run_ = true;
    wake_.notify_all();
    return true;
  }

  /// Answers when the tare is in force: the next sample on the topic has it.
  bool on_bias(Trigger::Request&, Trigger::Response& response) {
    std::unique_lock<std::mutex> lock(mutex_);
    response.success = false;
    response.message = "no reading yet: the sensor is read during a run";
    if (held_) response.message = "held: no readings until rig/start";
    if (!running_ || held_ || quit_) return true;
    want_bias_ = true;
    wake_.notify_all();
    wake_.wait(lock, [this] { return !want_bias_ || !running_ || held_ || quit_; });
    if (want_bias_) {
      want_bias_ = false;
      return true;
    }
    response.success = bias_taken_;
    if (bias_taken_) response.message = "tared";
    return true;
  }

  void set_status(const std::string& status) {
    std_msgs::String message;
    message.data = status;
    status_.publish(message);
  }

  void work() {
    for (;;) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        wake_.wait(lock, [this] { return want_run_ || quit_; });
        if (quit_) return;
        want_run_ = want_stop_ = want_bias_ = false;
        running_ = true;
        failure_.clear();
      }
      std::string outcome = "finished";
      try {
        run_once();
      } catch (const std::exception& error) {
        ROS_ERROR("virtual_rig: %s", error.what());
        outcome = "failed";
        const std::lock_guard<std::mutex> lock(mutex_);
        failure_ = error.what();
      }
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        running_ = held_ = want_run_ = false;
      }
      wake_.notify_all();
      set_status(outcome);
    }
  }

  /// The first run writes `bag`, later ones get their number before the extension.
  std::string next_bag() {
    ++runs_;
    if (settings_.bag.empty() || runs_ == 1) return settings_.bag;
    std::filesystem::path path(settings_.bag);
    path.replace_filename(fmt::format("{}_{}{}", path.stem().string(), runs_, path.extension().string()));
    return path.string();
  }

  double epoch() const {
    if (settings_.publish_clock) return ros::WallTime::now().toSec();
    if (!ros::Time::isValid() && !ros::Time::waitForValid(ros::WallDuration(10.0)))
      throw Error(
          "use_sim_time is set and nothing publishes /clock: set publish_clock to let this rig do it");
    return ros::Time::now().toSec();
  }

  /// Soil and wheel of this run, in other nodes: `settings` get the height at which the run can start.
  void open_remote(rig::RunSettings& settings) {
    const RigSetup& setup = settings_.setup;
    set_status("preparing");
    const RemoteWheel::Opening opening =
        remote_->open(settings_.resume && runs_ == 0 ? settings_.checkpoint : "", settings_.effects);
    const auto same = [](const char* what, const std::string& there, const std::string& here) {
      if (there != here)
        throw Error(fmt::format("{} '{}' in the co-simulation, '{}' on the rig", what, there, here));
    };
    same("wheel", opening.wheel, setup.wheel.name);
    same("soil", opening.soil, setup.soil.name);
    same("dem settings", opening.settings, setup.dem->name);
    settings.profile.clearance = opening.clearance;
  }

  void run_once() {
    rig::RunSettings settings = settings_.setup.run;
    settings.epoch = epoch();
    std::unique_ptr<rig::Contact> fast;
    if (!remote_) fast = make_contact(settings_.setup, acting_.ports);
    try {
      if (remote_) open_remote(settings);
      LiveRun run(settings, remote_ ? *remote_ : *fast, acting_.ports, next_bag());
      const ros::WallTime begin = ros::WallTime::now();
      drive(settings.epoch, run);
      run.close();
      const double wall = (ros::WallTime::now() - begin).toSec();
      ROS_INFO("virtual_rig: run %d is over, %.3f s simulated in %.2f s, %zu messages%s", runs_.load(),
               run.time(), wall, run.messages(), settings_.bag.empty() ? "" : " in its bag");
    } catch (const NodeEnds&) {
      return;
    } catch (const std::exception& error) {
      if (remote_) remote_->close(error.what());
      throw;
    }
    if (!remote_) return;
    remote_->close(quit_ || !ros::ok() ? "virtual_rig ends" : "");
    std::error_code ignored;
    if (!quit_ && ros::ok() && !settings_.checkpoint.empty())
      std::filesystem::remove(settings_.checkpoint, ignored);
  }

  /// To the end of the run or of the node. What was measured before wheel or soil fail is kept: the bag is
  /// closed.
  void drive(double epoch, LiveRun& run) {
    try {
      advance(epoch, run);
    } catch (const NodeEnds&) {
    } catch (const Error&) {
      if (remote_) run.close();
      throw;
    }
  }

  void advance(double epoch, LiveRun& run) {
    view_.clear();
    set_status("running");
    pacer_.start();
    const double piece =
        settings_.real_time_factor > 0.0 ? std::min(0.1, piece_wall * settings_.real_time_factor) : 0.05;
    double held_for = 0.0;  // wall time at rest does not count
    bool may_hold = settings_.hold_at_travel > 0.0;
    bool going = true;
    RunProgress progress;
    ros::WallTime saved = ros::WallTime::now();
    while (going && !run.done()) {
      if (!serve(run, progress.left())) break;
      const run_log::RunLog log = run.advance(run.time() + piece, patience);
      publish(epoch, log);
      show(epoch, run);
      if (remote_) {
        progress.update(run.time(), run.expected_end(), remote_->replaying());
        save_now_and_then(saved);
      }
      going = pacer_.wait_until(run.time() + held_for);
      if (may_hold && run.step().readings.joints.carriage_position >= settings_.hold_at_travel) {
        may_hold = false;
        view_.flush();
        if (remote_) remote_->hold();
        going = hold();
        pacer_.start();
        held_for = -run.time();
      }
    }
    view_.flush();
  }

  void save_now_and_then(ros::WallTime& saved) {
    const ros::WallTime now = ros::WallTime::now();
    if (settings_.checkpoint.empty() || remote_->replaying() ||
        (now - saved).toSec() < settings_.checkpoint_interval)
      return;
    remote_->write_checkpoint(settings_.checkpoint);
    saved = ros::WallTime::now();
  }

  /// Carries out what the services asked for. False: the node ends.
  bool serve(LiveRun& run, double left) {
    bool answered = false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (quit_ || !ros::ok()) return false;
      if (want_stop_) run.stop();
      if (want_bias_) bias_taken_ = run.bias();
      answered = want_bias_;
      want_stop_ = want_bias_ = want_run_ = false;
      time_ = run.time();
      phase_ = to_string(run.phase());
      left_ = left;
      messages_ = run.messages();
    }
    if (answered) wake_.notify_all();
    return true;
  }

  bool hold() {
    std::unique_lock<std::mutex> lock(mutex_);
    held_ = true;
    set_status("held");
    wake_.notify_all();
    wake_.wait(lock, [this] { return want_run_ || quit_; });
    held_ = false;
    const bool goes_on = !quit_;
    lock.unlock();
    if (goes_on) set_status("running");
    return goes_on;
  }

  void publish(double epoch, const run_log::RunLog& log) {
    for (std::size_t i = 0; i < log.ft.time.size(); ++i)
      wrench_.publish(
          to_message(to_stamp(epoch, log.ft.time[i]), settings_.frame, log.ft.force[i], log.ft.torque[i]));
    for (std::size_t i = 0; i < log.draw_wire.time.size(); ++i)
      displacement_.publish(
          to_message(to_stamp(epoch, log.draw_wire.time[i]), "rig", log.draw_wire.value[i]));
    const auto& j = log.joints;
    for (std::size_t i = 0; i < j.time.size(); ++i)
      joints_.publish(to_message(to_stamp(epoch, j.time[i]),
                                 rig::JointReading{j.carriage_position[i], j.carriage_velocity[i],
                                                   j.wheel_angle[i], j.wheel_rate[i], j.wheel_effort[i]}));
    for (std::size_t i = 0; i < log.temperature.time.size(); ++i)
      temperature_.publish(
          to_temperature(to_stamp(epoch, log.temperature.time[i]), log.temperature.value[i]));
  }

  void show(double epoch, const LiveRun& run) {
    const rig::RigStep& step = run.step();
    if (settings_.publish_clock) {
      rosgraph_msgs::Clock clock;
      clock.clock = to_stamp(epoch, run.time());
      clock_.publish(clock);
    }
    Gauges gauges;
    gauges.title = settings_.setup.title;
    gauges.phase = to_string(run.phase());
    gauges.time = run.time();
    gauges.slip = step.state.slip;
    gauges.measured = {step.load.force_hub_rig, step.state.hub_displacement,
                       step.readings.joints.wheel_effort};
    view_.show(step.motion.position.x(), step.motion.wheel_angle, step.motion.steering_angle, gauges);
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    using diagnostic_msgs::DiagnosticStatus;
    const std::lock_guard<std::mutex> lock(mutex_);
    const double reached = pacer_.reached();
    const double lag = pacer_.lag();
    if (!failure_.empty())
      status.summary(DiagnosticStatus::ERROR, failure_);
    else if (!running_)
      status.summary(DiagnosticStatus::OK, "no run");
    else if (held_)
      status.summary(DiagnosticStatus::OK, "held");
    else if (lag > 0.1)
      status.summary(DiagnosticStatus::WARN,
                     fmt::format("{:.2f} s behind the real-time factor asked for", lag));
    else
      status.summary(DiagnosticStatus::OK, phase_);
    status.add("run", runs_);
    status.add("time in the run (s)", time_);
    if (remote_) status.add("time left (s)", left_);
    status.add("real-time factor asked for", settings_.real_time_factor);
    status.add("real-time factor reached", reached);
    status.add("messages of the run", messages_);
    status.add("bag", settings_.bag);
  }

  Settings settings_;
  effects::Acting acting_;  // of these what acts on rig and sensors; all of them when the contact is here
  ros::NodeHandle node_;
  Pacer pacer_;
  RigView view_;
  std::unique_ptr<RemoteWheel> remote_;  // fidelity dem
  diagnostic_updater::Updater updater_;
  ros::Publisher wrench_, displacement_, joints_, temperature_, status_, clock_;
  ros::ServiceServer start_, stop_, bias_;
  ros::WallTimer timer_;

  std::mutex mutex_;  // guards what follows
  std::condition_variable wake_;
  bool want_run_ = false;
  bool want_stop_ = false;
  bool want_bias_ = false;
  bool bias_taken_ = false;
  bool running_ = false;
  bool held_ = false;
  std::atomic<bool> quit_{false};
  double left_ = 0.0;
  std::string failure_;
  std::string phase_;
  double time_ = 0.0;
  std::size_t messages_ = 0;
  std::atomic<int> runs_{0};
  std::thread worker_;
};

VirtualRigBridge::VirtualRigBridge(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : impl_(std::make_unique<Impl>(node, private_node)) {}
VirtualRigBridge::~VirtualRigBridge() = default;

}  // namespace wheel_twin::nodes
