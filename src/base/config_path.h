// Where wheels, soils, rigs, sensors and experiments are found by name: the folder in the environment
// variable WHEEL_TWIN_CONFIG when it is set, else the source tree's `config`, else the installed one.
#pragma once

#include <string>

namespace wheel_twin {

/// The file that `name` stands for: itself when it has a slash or ends in .yaml, else
/// <config>/<kind>/<name>.yaml. `kind` is the folder: "wheels", "soils", ... Throws Error naming what was
/// looked for and where, with the names there are.
std::string find_config(const std::string& kind, const std::string& name);

/// The configuration folder in use.
std::string config_folder();

}  // namespace wheel_twin
