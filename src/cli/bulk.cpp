#include <fmt/format.h>

#include "bulk/angle_of_repose.h"
#include "bulk/direct_shear.h"
#include "bulk/plate_sinkage.h"
#include "cli/commands.h"

namespace wheel_twin::cli {
namespace {

constexpr double degrees = 180.0 / 3.14159265358979323846;

struct Common {
  std::string soil;
  std::string out;
};

void add_common(CLI::App* command, const std::shared_ptr<Common>& common) {
  command->add_option("--soil", common->soil, "name in config/soils or a file")->required();
  command->add_option("--out", common->out, "folder for curves (CSV), picture (SVG) and JSON")->required();
}

void add_direct_shear(CLI::App* parent) {
  auto common = std::make_shared<Common>();
  auto settings = std::make_shared<bulk::ShearSettings>();
  CLI::App* command =
      parent->add_subcommand("direct_shear", "Direct shear box of the paper: cohesion and friction angle");
  add_common(command, common);
  command->add_option("--normal-stress", settings->normal_stresses, "Pa, one or more")->capture_default_str();
  command->add_option("--rate", settings->rate, "of the lower frame, m/s")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--travel", settings->travel, "of the lower frame, m")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--consolidation", settings->consolidation_time, "s")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--seed", settings->seed, "another seed, another sample")->capture_default_str();
  command->add_option("--threads", settings->threads, "threads")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command->footer("Example: twin bulk direct_shear --soil mars_simulant --rate 0.02 --out shear");
  command->callback([common, settings] {
    const dem::GranularSoil soil = dem::load_granular_soil(common->soil);
    const bulk::ShearResult result = bulk::direct_shear(soil, *settings);
    bulk::write_shear_report(common->out, soil, *settings, result);
    fmt::print(
        "{}: cohesion {:.3f} kPa, angle of internal friction {:.2f} degrees, void ratio {:.3f}, {} clumps\n",
        common->out, result.cohesion() / 1e3, result.friction_angle() * degrees, result.sample.void_ratio,
        result.sample.clumps);
  });
}

void add_angle_of_repose(CLI::App* parent) {
  auto common = std::make_shared<Common>();
  auto settings = std::make_shared<bulk::ReposeSettings>();
  CLI::App* command =
      parent->add_subcommand("angle_of_repose", "A heap from a funnel and the angle of its flank");
  add_common(command, common);
  command->add_option("--clumps", settings->clumps, "in the funnel")
      ->capture_default_str()
      ->check(CLI::Range(50, 10000000));
  command->add_option("--seed", settings->seed, "another seed, another heap")->capture_default_str();
  command->add_option("--threads", settings->threads, "threads")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command->footer("Example: twin bulk angle_of_repose --soil mars_simulant --out repose");
  command->callback([common, settings] {
    const dem::GranularSoil soil = dem::load_granular_soil(common->soil);
    const bulk::ReposeResult result = bulk::angle_of_repose(soil, *settings);
    bulk::write_repose_report(common->out, soil, *settings, result);
    fmt::print("{}: angle of repose {:.2f} degrees (standard error {:.2f})\n", common->out,
               result.angle * degrees, result.angle_error * degrees);
  });
}

void add_plate_sinkage(CLI::App* parent) {
  auto common = std::make_shared<Common>();
  auto settings = std::make_shared<bulk::SinkageSettings>();
  CLI::App* command =
      parent->add_subcommand("plate_sinkage", "Circular plates pressed into a settled bed: Bekker's moduli");
  add_common(command, common);
  command->add_option("--diameter", settings->diameters, "of the plates, m, one or more")
      ->capture_default_str();
  command->add_option("--rate", settings->rate, "of the plate, m/s")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--sinkage", settings->sinkage, "largest, m")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--bed-size", settings->bed_size, "length and width of the bed, m")
      ->capture_default_str();
  command->add_option("--bed-depth", settings->bed_depth, "m")->capture_default_str();
  command->add_option("--seed", settings->seed, "another seed, another bed")->capture_default_str();
  command->add_option("--threads", settings->threads, "threads")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command->footer("Example: twin bulk plate_sinkage --soil mars_simulant --out sinkage");
  command->callback([common, settings] {
    const dem::GranularSoil soil = dem::load_granular_soil(common->soil);
    const bulk::SinkageResult result = bulk::plate_sinkage(soil, *settings);
    bulk::write_sinkage_report(common->out, soil, *settings, result);
    fmt::print("{}: n {:.3f}, k_c {:.4g} N/m^(n+1), k_phi {:.4g} N/m^(n+2)\n", common->out, result.n,
               result.k_c, result.k_phi);
  });
}

}  // namespace

void add_bulk(CLI::App& app) {
  CLI::App* command = app.add_subcommand("bulk", "Virtual bulk tests of a granular soil");
  command->require_subcommand(1);
  add_direct_shear(command);
  add_angle_of_repose(command);
  add_plate_sinkage(command);
}

}  // namespace wheel_twin::cli
