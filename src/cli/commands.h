// The subcommands of `twin`. Each adds itself to the program: options, help with an example, and what to do.
#pragma once

#include <CLI/CLI.hpp>

namespace wheel_twin::cli {

// One line a subcommand, in the order of the help page.

}  // namespace wheel_twin::cli
