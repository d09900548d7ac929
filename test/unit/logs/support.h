// A scratch directory and made-up runs for the tests of logs.
#pragma once

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "../message_of.h"
#include "base/random.h"
#include "run_log/run_log.h"

namespace wheel_twin::logs {

/// A directory of its own, removed at the end of the test.
class Scratch {
 public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "wheel_twin_logs_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Scratch() { std::filesystem::remove_all(path_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline std::string bytes_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

inline void put_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline double rounded(double value, double resolution) {
  return std::round(value / resolution) * resolution;
}

/// A sound run as a rig would log it: 2 s hanging over the soil, lowered, then rolling; noise and resolution
/// of the sensors.
inline run_log::RunLog sound_run(double duration = 20.0, double rate = 50.0, std::uint64_t seed = 1) {
  Random random(seed);
  run_log::RunLog log;
  log.epoch = 1700000000.25;
  const auto count = static_cast<std::size_t>(duration * rate);
  double angle = 0.0;
  double position = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate;
    const double load = 42.1 * std::min(1.0, std::max(0.0, (t - 2.0) / 1.0));
    const double ramp = std::min(1.0, std::max(0.0, (t - 4.0) / 1.0));
    const double rate_now = 0.28 * ramp;
    angle += rate_now / rate;
    position += 0.014 * ramp / rate;
    const auto force = [&](double mean, double noise) {
      return rounded(mean + noise * random.normal(), 1.0 / 16.0);
    };
    log.ft.time.push_back(t);
    log.ft.force.emplace_back(force(0.35 * load * ramp, 0.06), force(0.0, 0.06), force(load, 0.06));
    log.ft.torque.emplace_back(0.0, rounded(0.03 * load * ramp + 0.002 * random.normal(), 1.0 / 752.0), 0.0);
    log.draw_wire.time.push_back(t);
    const double depth = t < 2.0 ? 0.005 * (t - 2.0) : 0.011 * load / 42.1 + 0.004 * ramp;
    log.draw_wire.value.push_back(rounded(depth + 3e-5 * random.normal(), 5e-5));
    log.joints.time.push_back(t);
    log.joints.carriage_position.push_back(position);
    log.joints.carriage_velocity.push_back(0.014 * ramp + 1e-5 * random.normal());
    log.joints.wheel_angle.push_back(angle);
    log.joints.wheel_rate.push_back(rate_now + 1e-4 * random.normal());
    log.joints.wheel_effort.push_back(0.03 * load * ramp + 0.002 * random.normal());
    if (i % static_cast<std::size_t>(rate) == 0) {
      log.temperature.time.push_back(t);
      log.temperature.value.push_back(21.0 + 0.01 * random.normal());
    }
  }
  return log;
}

}  // namespace wheel_twin::logs
