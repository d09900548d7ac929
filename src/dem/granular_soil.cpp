#include "dem/granular_soil.h"

#include <fmt/format.h>

#include "base/config_path.h"

namespace wheel_twin::dem {
namespace {

Material read_material(const std::string& name, const yaml::Map& map) {
  Material material;
  material.name = name;
  material.density = map.number("density", yaml::positive());
  material.shear_modulus = map.number("shear_modulus", yaml::positive());
  material.poisson_ratio = map.number("poisson_ratio", {-0.99, 0.49});
  return material;
}

PairProperties read_pair(const yaml::Map& map) {
  PairProperties pair;
  pair.restitution = map.number("restitution", {1e-3, 1.0});
  pair.friction = map.number("friction", {0.0, 10.0});
  pair.rolling_friction = map.number_or("rolling_friction", 0.0, {0.0, 10.0});
  pair.cohesion_energy_density = map.number_or("cohesion_energy_density", 0.0, yaml::non_negative());
  return pair;
}

std::string text_of(const Material& m) {
  return fmt::format("{} {} {}", m.density, m.shear_modulus, m.poisson_ratio);
}

std::string text_of(const PairProperties& p) {
  return fmt::format("{} {} {} {}", p.restitution, p.friction, p.rolling_friction, p.cohesion_energy_density);
}

}  // namespace

MaterialTable GranularSoil::materials() const {
  MaterialTable table;
  table.add(grain);
  table.add(wall);
  table.set_pair(grain_material, grain_material, grain_grain);
  table.set_pair(grain_material, wall_material, grain_wall);
  return table;
}

std::string GranularSoil::fingerprint() const {
  std::string text = fmt::format("grain {} wall {} grain_grain {} grain_wall {} step {} size {} {}\n",
                                 text_of(grain), text_of(wall), text_of(grain_grain), text_of(grain_wall),
                                 step_fraction, clumps.smallest_size, clumps.largest_size);
  for (std::size_t i = 0; i < clumps.shapes.size(); ++i) {
    text += fmt::format("shape {}", clumps.shares[i]);
    for (const ClumpSphere& s : clumps.shapes[i].spheres)
      text += fmt::format(" {} {} {} {}", s.center.x(), s.center.y(), s.center.z(), s.radius);
    text += '\n';
  }
  return text;
}

GranularSoil read_granular_soil(const yaml::Map& section) {
  GranularSoil soil;
  soil.clumps = read_clump_family(yaml::parse_file(find_config("clumps", section.text("clumps"))));
  soil.grain = read_material("soil", section);
  soil.grain_grain = read_pair(section);
  soil.packing_density = section.number("packing_density", {0.05, 0.9});
  soil.shear_box_void_ratio =
      section.number_or("shear_box_void_ratio", 1.0 / soil.packing_density - 1.0, {0.1, 10.0});
  soil.step_fraction = section.number_or("step_fraction", soil.step_fraction, {0.01, 0.5});
  const yaml::Map wall = section.map("wall");
  soil.wall = read_material("wall", wall);
  soil.grain_wall = read_pair(wall);
  wall.finish();
  section.finish();
  return soil;
}

GranularSoil load_granular_soil(const std::string& name) {
  const yaml::Map file = yaml::parse_file(find_config("soils", name));
  if (!file.has("dem")) file.fail("dem", "is missing: this soil has no discrete-element section");
  GranularSoil soil = read_granular_soil(file.map("dem"));
  soil.name = file.text_or("name", name);
  return soil;
}

}  // namespace wheel_twin::dem
