#include "dem/cache.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

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

Archive fetch(const std::string& kind, const std::string& description, const std::function<Archive()>& make) {
  const std::string path = cache_path(kind, description);
  if (std::filesystem::exists(path)) {
    try {
      return read_archive(path, kind);
    } catch (const Error& error) {
      fmt::print(stderr, "{}; it is made again\n", error.what());
    }
  }
  Archive archive = make();
  archive.set_text("description", description);
  write_archive(path, kind, archive);
  return archive;
}

}  // namespace wheel_twin::dem
