// Any text as an experiment file. Nothing but wheel_twin::Error may come out.
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/error.h"
#include "base/yaml.h"
#include "logs/experiment.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    wheel_twin::logs::read_experiment(wheel_twin::yaml::parse_text(text, "fuzz.yaml"), ".");
  } catch (const wheel_twin::Error&) {
    return 0;
  }
  return 0;
}
