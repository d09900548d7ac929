#include "dem/cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace wheel_twin::dem {

std::string cache_folder() {
  std::filesystem::path folder;
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value == nullptr ? "" : value);
  };
  if (!variable("WHEEL_TWIN_CACHE").empty())
    folder = variable("WHEEL_TWIN_CACHE");
  else if (!variable("XDG_CACHE_HOME").empty())
    folder = std::filesystem::path(variable("XDG_CACHE_HOME")) / "wheel_twin";
  else if (!variable("HOME").empty())
    folder = std::filesystem::path(variable("HOME")) / ".cache" / "wheel_twin";
  else
    throw Error("no folder for the cache: set WHEEL_TWIN_CACHE, XDG_CACHE_HOME or HOME");
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw Error(fmt::format("{}: cannot be made: {}", folder.string(), code.message()));
  return folder.string();
}

std::string cache_path(const std::string& kind, const std::string& description) {
  return fmt::format("{}/{}-{}.h5", cache_folder(), kind, sha256(description).substr(0, 32));
}

namespace {

/// Held while a file of the cache is made; the system drops it with the process.
class MakingLock {
 public:
  explicit MakingLock(std::string path) : path_(std::move(path)) {
    file_ = open(path_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file_ < 0) throw Error(fmt::format("{}: cannot be opened: {}", path_, std::strerror(errno)));
    if (flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    fmt::print(stderr, "{}: waiting for another process that makes it\n", path_);
    while (flock(file_, LOCK_EX) != 0) {
      if (errno != EINTR) throw Error(fmt::format("{}: cannot be locked: {}", path_, std::strerror(errno)));
    }
  }
  // Removed while it is held: who waits for it, or makes a new one, finds the finished file.
  ~MakingLock() {
    unlink(path_.c_str());
    close(file_);
  }
  MakingLock(const MakingLock&) = delete;
  MakingLock& operator=(const MakingLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;
};

std::optional<Archive> read_good(const std::string& path, const std::string& kind) {
  if (!std::filesystem::exists(path)) return {};
  try {
    return read_archive(path, kind);
  } catch (const Error& error) {
    fmt::print(stderr, "{}; it is made again\n", error.what());
    return {};
  }
}

}  // namespace

Archive fetch(const std::string& kind, const std::string& description, const std::function<Archive()>& make) {
  const std::string path = cache_path(kind, description);
  if (std::optional<Archive> kept = read_good(path, kind)) return std::move(*kept);
  const MakingLock lock(path + ".lock");
  if (std::optional<Archive> made = read_good(path, kind)) return std::move(*made);
  Archive archive = make();
  archive.set_text("description", description);
  write_archive(path, kind, archive);
  return archive;
}

}  // namespace wheel_twin::dem
