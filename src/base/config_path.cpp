#include "base/config_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "base/error.h"

namespace wheel_twin {
namespace {

namespace fs = std::filesystem;

bool is_path(const std::string& name) {
  return name.find('/') != std::string::npos || fs::path(name).extension() == ".yaml";
}

std::string known_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

}  // namespace

std::string config_folder() {
  const char* environment = std::getenv("WHEEL_TWIN_CONFIG");
  if (environment != nullptr && *environment != '\0') {
    if (!fs::is_directory(environment))
      throw Error(fmt::format("WHEEL_TWIN_CONFIG: {} is not a directory", environment));
    return environment;
  }
  for (const char* candidate : {WHEEL_TWIN_SOURCE_CONFIG, WHEEL_TWIN_INSTALLED_CONFIG})
    if (fs::is_directory(candidate)) return candidate;
  throw Error(fmt::format("no configuration directory: neither {} nor {}; set WHEEL_TWIN_CONFIG",
                          WHEEL_TWIN_SOURCE_CONFIG, WHEEL_TWIN_INSTALLED_CONFIG));
}

std::string find_config(const std::string& kind, const std::string& name) {
  if (is_path(name)) {
    if (!fs::is_regular_file(name)) throw Error(fmt::format("{}: no such file", name));
    return name;
  }
  const fs::path folder = fs::path(config_folder()) / kind;
  const fs::path file = folder / (name + ".yaml");
  if (!fs::is_regular_file(file))
    throw Error(fmt::format("{}: no such file; known {}: {}", file.string(), kind, known_names(folder)));
  return file.string();
}

}  // namespace wheel_twin
