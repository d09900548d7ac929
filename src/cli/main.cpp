#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <new>

#include "cli/commands.h"

// Exit codes: 0 the work was done; 1 it was not, one line on standard error says why; 2 the call was wrong.
int main(int argc, char** argv) {
  CLI::App app{
      "Digital twin of a single-wheel test rig. `twin COMMAND --help` shows an example of each command."};
  app.require_subcommand(1);
  wheel_twin::cli::add_run(app);
  wheel_twin::cli::add_bed(app);
  wheel_twin::cli::add_bulk(app);
  wheel_twin::cli::add_calibrate(app);
  wheel_twin::cli::add_import(app);
  wheel_twin::cli::add_check(app);
  wheel_twin::cli::add_compare(app);
  wheel_twin::cli::add_survey(app);
  wheel_twin::cli::add_diagnose(app);
  wheel_twin::cli::add_evaluate(app);
  wheel_twin::cli::add_steady(app);
  wheel_twin::cli::add_wheel(app);
  wheel_twin::cli::add_bench(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "twin: there is not enough memory for this\n");
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "twin: {}\n", error.what());
    return 1;
  }
  return 0;
}
