// The subcommands of `twin`. Each adds itself to the program: options, help with an example, and what to do.
#pragma once

#include <CLI/CLI.hpp>

namespace wheel_twin::cli {

// One line a subcommand, in the order of the help page.
void add_run(CLI::App& app);
void add_bed(CLI::App& app);
void add_bulk(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_import(CLI::App& app);
void add_check(CLI::App& app);
void add_compare(CLI::App& app);
void add_survey(CLI::App& app);
void add_diagnose(CLI::App& app);
void add_evaluate(CLI::App& app);
void add_steady(CLI::App& app);
void add_wheel(CLI::App& app);
void add_bench(CLI::App& app);

}  // namespace wheel_twin::cli
