#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/plot.h"
#include "bulk/folder.h"
#include "cli/commands.h"
#include "dem/bed.h"
#include "dem/soil_export.h"

namespace wheel_twin::cli {
namespace {

struct Options {
  std::string soil;
  std::string out;
  dem::BedSettings bed;
  std::optional<double> fill_friction;
  bool walls = false;
  int threads = 1;
};

void write_report(const Options& options, const dem::GranularSoil& soil, const dem::Bed& bed) {
  const dem::BedReport& r = bed.report;
  const dem::BedSettings& s = bed.settings;
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  Plot plot{fmt::format("Settled bed, {}", soil.name),
            "packing density",
            "height above the floor (mm)",
            {},
            {},
            {}};
  PlotSeries profile{"layers", {}, {}};
  std::string csv = "height_above_floor_m,packing_density\n";
  for (std::size_t i = 0; i < r.layer_density.size(); ++i) {
    const double height = (static_cast<double>(i) + 0.5) * r.layer_thickness;
    layers.push_back(r.layer_density[i]);
    csv += fmt::format("{:.6g},{:.6g}\n", height, r.layer_density[i]);
    profile.x.push_back(r.layer_density[i]);
    profile.y.push_back(1e3 * height);
  }
  plot.series = {profile,
                 {fmt::format("mean {:.4f}", r.packing_density),
                  {r.packing_density, r.packing_density},
                  {1e3 * r.margin, 1e3 * (s.depth - r.margin)},
                  PlotSeries::Style::dashed}};
  const nlohmann::ordered_json json = {
      {"schema", 1},
      {"soil", soil.name},
      {"size", {{"length", s.length}, {"width", s.width}, {"depth", s.depth}, {"unit", "m"}}},
      {"periodic", {{"x", s.periodic_x}, {"y", s.periodic_y}}},
      {"seed", s.seed},
      {"clumps", r.clumps},
      {"spheres", r.spheres},
      {"friction_while_filling", r.fill_friction},
      {"packing_density",
       {{"value", r.packing_density}, {"wanted", soil.packing_density}, {"margin_m", r.margin}}},
      {"layer_density", layers},
      {"layer_thickness", {{"value", r.layer_thickness}, {"unit", "m"}}},
      {"kinetic_energy", {{"value", r.kinetic_energy}, {"unit", "J"}}},
      {"weight", {{"value", r.weight}, {"unit", "N"}}},
      {"floor_force", {{"value", r.floor_force}, {"unit", "N"}}},
      {"coordination", {{"per_clump", r.coordination.per_clump}, {"per_sphere", r.coordination.per_sphere}}},
      {"simulated_time", {{"value", r.simulated_time}, {"unit", "s"}}}};
  bulk::make_folder(options.out);
  write_file(options.out + "/layers.csv", csv);
  write_svg(options.out + "/layers.svg", {plot});
  write_file(options.out + "/bed.json", json.dump(2) + "\n");
}

void run(Options options) {
  const dem::GranularSoil soil = dem::load_granular_soil(options.soil);
  options.bed.fill_friction = options.fill_friction;
  options.bed.periodic_x = options.bed.periodic_y = !options.walls;
  const dem::Bed bed = dem::fetch_bed(soil, options.bed, options.threads);
  write_report(options, soil, bed);
  dem::write_bed(options.out + "/bed.h5", bed, dem::bed_description(soil, options.bed));
  dem::write_spheres_vtp(options.out + "/bed.vtp", dem::bed_system(soil, bed, 0.05, 1));
  const dem::BedReport& r = bed.report;
  fmt::print(
      "{}: {} clumps, {} spheres, packing density {:.4f}, kinetic energy {:.2g} J, floor carries {:.4f} of "
      "the weight\n",
      options.out, r.clumps, r.spheres, r.packing_density, r.kinetic_energy, r.floor_force / r.weight);
  if (std::abs(r.packing_density - soil.packing_density) > 0.005)
    throw Error(fmt::format("bed: packing density {:.4f} misses the wanted {:.4f} by more than 0.005",
                            r.packing_density, soil.packing_density));
}

}  // namespace

void add_bed(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("bed", "Prepare or fetch a settled soil bed");
  command->add_option("--soil", options->soil, "name in config/soils or a file")->required();
  command->add_option("--out", options->out, "folder for bed.h5, bed.json, layers.csv, layers.svg, bed.vtp")
      ->required();
  command->add_option("--length", options->bed.length, "along travel, m")->capture_default_str();
  command->add_option("--width", options->bed.width, "m")->capture_default_str();
  command->add_option("--depth", options->bed.depth, "m")->capture_default_str();
  command->add_flag("--walls", options->walls, "walls around the bed instead of periodic sides");
  command->add_option("--gravity", options->bed.gravity, "m/s^2")->capture_default_str();
  command->add_option("--seed", options->bed.seed, "another seed, another bed")->capture_default_str();
  command
      ->add_option("--cloud-density", options->bed.cloud_density,
                   "packing density of the cloud that falls; smaller is more like rain")
      ->capture_default_str();
  command->add_option("--fill-friction", options->fill_friction,
                      "friction while filling; default: tuned to the density");
  command->add_option("--threads", options->threads, "threads")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  command->footer("Example: twin bed --soil mars_simulant --out bed");
  command->callback([options] { run(*options); });
}

}  // namespace wheel_twin::cli
