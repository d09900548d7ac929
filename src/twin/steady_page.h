// What a diagnosis by window means adds to diagnosis.json and to the page.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "twin/steady_report.h"

namespace wheel_twin::twin {

nlohmann::ordered_json steady_json(const SteadyReport& report);

/// Tables and plots: errors on groups left out, every channel against slip, every run.
std::string steady_html(const SteadyReport& report);

/// One line a run and channel: measured and every twin.
std::string steady_csv(const SteadyReport& report);

}  // namespace wheel_twin::twin
