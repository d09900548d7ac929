#include "cosim/dem_settings.h"

#include <fmt/format.h>

#include "base/config_path.h"

namespace wheel_twin::cosim {

DemSettings read_dem_settings(const yaml::Map& map) {
  DemSettings s;
  s.name = map.text("name");
  const yaml::Map bed = map.map("bed");
  s.bed.length = bed.number("length", {0.05, 10.0});
  s.bed.width = bed.number("width", {0.03, 10.0});
  s.bed.depth = bed.number("depth", {0.02, 2.0});
  s.bed.periodic_x = s.bed.periodic_y = bed.boolean("periodic");
  s.bed.fill_friction = bed.optional_number("fill_friction", {0.004, 10.0});
  bed.finish();
  s.grain_scale = map.number("grain_scale", {0.2, 5.0});
  s.step_fraction = map.optional_number("step_fraction", {0.01, 0.5});
  s.start_x = map.number("start_x", {0.0, s.bed.length});
  s.headroom = map.number_or("headroom", s.headroom, {0.05, 5.0});
  if (map.has("sleep")) {
    const yaml::Map sleep = map.map("sleep");
    s.sleep.enabled = true;
    s.sleep.speed = sleep.number("speed", yaml::positive());
    s.sleep.force = sleep.number("force", yaml::positive());
    s.sleep.time = sleep.number("time", yaml::positive());
    sleep.finish();
  }
  if (map.has("window")) {
    const yaml::Map window = map.map("window");
    s.window = BedWindow{window.number("behind", yaml::positive()), window.number("ahead", yaml::positive())};
    window.finish();
  }
  const yaml::Map profile = map.map("profile");
  s.profile.lowering_speed = profile.number("lowering_speed", {0.001, 1.0});
  s.profile.dwell = profile.number("dwell", yaml::non_negative());
  s.profile.ramp = profile.number("ramp", yaml::positive());
  s.profile.longest_steady = profile.number("duration", yaml::positive());
  s.profile.rest = profile.number("rest", yaml::non_negative());
  s.profile.travel = 0.0;
  profile.finish();
  map.finish();
  return s;
}

DemSettings load_dem_settings(const std::string& name) {
  return read_dem_settings(yaml::parse_file(find_config("dem", name)));
}

dem::GranularSoil scaled_soil(dem::GranularSoil soil, const DemSettings& settings) {
  if (settings.grain_scale == 1.0) return soil;
  for (dem::ClumpTemplate& shape : soil.clumps.shapes) {
    std::vector<dem::ClumpSphere> spheres = shape.spheres;
    for (dem::ClumpSphere& sphere : spheres) {
      sphere.center *= settings.grain_scale;
      sphere.radius *= settings.grain_scale;
    }
    shape = dem::make_clump(shape.name, std::move(spheres));
  }
  return soil;
}

}  // namespace wheel_twin::cosim
