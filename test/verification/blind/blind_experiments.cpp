// blind_experiments --out DIR --first 1 --count 100: experiments with something hidden in them, and the truth
// in DIR/truth, for scripts/validate blind.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/error.h"
#include "draw.h"
#include "write.h"

int main(int argc, char** argv) {
  CLI::App app("Experiments with something hidden in them, for the blind test of the diagnosis");
  std::string out;
  std::uint64_t first = 1, count = 100;
  app.add_option("--out", out, "folder")->required();
  app.add_option("--first", first, "seed of the first experiment");
  app.add_option("--count", count, "experiments");
  CLI11_PARSE(app, argc, argv);
  try {
    for (std::uint64_t seed = first; seed < first + count; ++seed)
      wheel_twin::blind::write(wheel_twin::blind::draw(seed), fmt::format("blind_{:03}", seed), out, seed);
  } catch (const wheel_twin::Error& error) {
    fmt::print(stderr, "blind_experiments: {}\n", error.what());
    return 1;
  }
  return 0;
}
