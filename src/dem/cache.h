// A folder of things that are costly to make and fully determined by a text: settled beds, shear samples. The
// name of a file is the SHA-256 of that text, so nothing in it is ever out of date.
#pragma once

#include <functional>
#include <string>

#include "dem/archive.h"

namespace wheel_twin::dem {

/// $WHEEL_TWIN_CACHE, else $XDG_CACHE_HOME/wheel_twin, else $HOME/.cache/wheel_twin; made when missing.
std::string cache_folder();

/// Where the thing that `description` determines is or will be kept.
std::string cache_path(const std::string& kind, const std::string& description);

/// Reads the file when it is there and good; else calls `make` and keeps what it returns. A damaged file or
/// one of another version is made anew, with one line on standard error that says so. Of several callers at
/// once, in any processes, one makes it and the others wait.
Archive fetch(const std::string& kind, const std::string& description, const std::function<Archive()>& make);

}  // namespace wheel_twin::dem
