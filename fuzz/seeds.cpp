// Writes small sound bags, without their version line, into a directory: fuzz_seeds DIRECTORY
#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <string>

#include "logs/bag_writer.h"

int main(int argc, char** argv) {
  using wheel_twin::logs::Compression;
  if (argc != 2) return 2;
  wheel_twin::run_log::RunLog log;
  log.epoch = 1700000000.0;
  for (int i = 0; i < 25; ++i) {
    const double t = 0.02 * i;
    log.ft.time.push_back(t);
    log.ft.force.emplace_back(1.0, 0.0, 42.0 + 0.0625 * (i % 3));
    log.ft.torque.emplace_back(0.0, 0.5, 0.0);
    log.draw_wire.time.push_back(t);
    log.draw_wire.value.push_back(0.01);
    log.joints.time.push_back(t);
    log.joints.carriage_position.push_back(0.02 * t);
    log.joints.carriage_velocity.push_back(0.02);
    log.joints.wheel_angle.push_back(0.3 * t);
    log.joints.wheel_rate.push_back(0.3);
    log.joints.wheel_effort.push_back(1.0);
  }
  log.temperature = {{0.0}, {21.0}};
  const std::string directory = argv[1];
  const char* const names[] = {"none", "bz2", "lz4"};
  for (const Compression compression : {Compression::none, Compression::bz2, Compression::lz4}) {
    const std::string path = fmt::format("{}/{}", directory, names[static_cast<int>(compression)]);
    wheel_twin::logs::write_bag(log, path, compression);
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    const std::string rest = bytes.str().substr(sizeof("#ROSBAG V2.0\n") - 1);
    std::ofstream(path, std::ios::binary | std::ios::trunc) << rest;
  }
  return 0;
}
