#include "base/atomic_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace wheel_twin {

AtomicFile::AtomicFile(std::string target)
    : target_(std::move(target)), temporary_(fmt::format("{}.partial-{}", target_, getpid())) {}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  std::error_code code;
  std::filesystem::rename(temporary_, target_, code);
  if (code) throw Error(fmt::format("{}: cannot be written: {}", target_, code.message()));
  committed_ = true;
}

void write_file(const std::string& target, const std::string& content) {
  AtomicFile file(target);
  {
    std::ofstream stream(file.path(), std::ios::binary);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.close();
    if (!stream) throw Error(fmt::format("{}: cannot be written", target));
  }
  file.commit();
}

}  // namespace wheel_twin
