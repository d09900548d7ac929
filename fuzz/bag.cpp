// Any bytes as a bag: scanned, read and checked. Nothing but wheel_twin::Error may come out.
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/error.h"
#include "logs/bag_reader.h"
#include "logs/byte_source.h"
#include "logs/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The version line is given, so that mutations reach what lies behind it.
  std::string bytes = "#ROSBAG V2.0\n";
  bytes.append(reinterpret_cast<const char*>(data), size);
  wheel_twin::logs::MemorySource source(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  try {
    const auto recording = wheel_twin::logs::read_recording(source, "fuzz.bag");
    const auto report = wheel_twin::logs::check_recording(recording, "fuzz.bag");
    wheel_twin::logs::to_text(report);
    wheel_twin::logs::to_json({report});
  } catch (const wheel_twin::Error&) {
    return 0;
  }
  return 0;
}
