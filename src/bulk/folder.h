// The folder of a test's results.
#pragma once

#include <string>

namespace wheel_twin::bulk {

/// Makes the folder and those above it when they are missing. Throws Error naming it.
void make_folder(const std::string& folder);

}  // namespace wheel_twin::bulk
