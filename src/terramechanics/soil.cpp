#include "terramechanics/soil.h"

namespace wheel_twin::terramechanics {

Soil read_soil(const yaml::Map& map) {
  Soil soil;
  soil.name = map.text_or("name", soil.name);
  soil.k_c = map.number("k_c", {-1e9, 1e9});
  soil.k_phi = map.number("k_phi", {-1e12, 1e12});
  soil.n = map.number("n", {0.1, 2.5});
  soil.c = map.number("c", {0.0, 1e6});
  soil.phi = map.number("phi", {0.0, 1.2});
  soil.K = map.number("K", {1e-5, 1.0});
  soil.c1 = map.number("c1", {0.0, 1.0});
  soil.c2 = map.number("c2", {-1.0, 1.0});
  soil.gamma = map.number("gamma", {0.0, 1.0});
  soil.weight_density = map.number_or("weight_density", soil.weight_density, yaml::positive());
  map.skip("dem");
  map.finish();
  return soil;
}

}  // namespace wheel_twin::terramechanics
