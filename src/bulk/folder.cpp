#include "bulk/folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "base/error.h"

namespace wheel_twin::bulk {

void make_folder(const std::string& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw Error(fmt::format("{}: cannot be made: {}", folder, code.message()));
}

}  // namespace wheel_twin::bulk
