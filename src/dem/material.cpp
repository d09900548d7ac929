#include "dem/material.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"

namespace wheel_twin::dem {

std::uint32_t MaterialTable::add(const Material& material) {
  const auto refuse = [&](const char* what, double value) {
    throw Error(fmt::format("material '{}': {} {} is out of range", material.name, what, value));
  };
  if (!(material.density > 0.0) || !std::isfinite(material.density)) refuse("density", material.density);
  if (!(material.shear_modulus > 0.0) || !std::isfinite(material.shear_modulus)) {
    refuse("shear modulus", material.shear_modulus);
  }
  if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5)) {
    refuse("Poisson ratio", material.poisson_ratio);
  }
  materials_.push_back(material);
  for (auto& row : pairs_) row.emplace_back();
  pairs_.emplace_back(materials_.size());
  return static_cast<std::uint32_t>(materials_.size() - 1);
}

void MaterialTable::set_pair(std::uint32_t a, std::uint32_t b, const PairProperties& properties) {
  if (a >= size() || b >= size()) {
    throw Error(fmt::format("materials {} and {}: there are only {}", a, b, size()));
  }
  const auto refuse = [&](const char* what, double value) {
    throw Error(fmt::format("materials '{}' and '{}': {} {} is out of range", materials_[a].name,
                            materials_[b].name, what, value));
  };
  const auto non_negative = [](double value) { return value >= 0.0 && std::isfinite(value); };
  if (!(properties.restitution > 0.0 && properties.restitution <= 1.0)) {
    refuse("restitution", properties.restitution);
  }
  if (!non_negative(properties.friction)) refuse("friction", properties.friction);
  if (!non_negative(properties.rolling_friction)) refuse("rolling friction", properties.rolling_friction);
  if (!non_negative(properties.cohesion_energy_density)) {
    refuse("cohesion energy density", properties.cohesion_energy_density);
  }
  pairs_[a][b] = properties;
  pairs_[b][a] = properties;
}

bool MaterialTable::rolling() const {
  for (const auto& row : pairs_) {
    for (const auto& pair : row) {
      if (pair.rolling_friction > 0.0) return true;
    }
  }
  return false;
}

bool MaterialTable::cohesive() const {
  for (const auto& row : pairs_) {
    for (const auto& pair : row) {
      if (pair.cohesion_energy_density > 0.0) return true;
    }
  }
  return false;
}

double rayleigh_time(const Material& material, double radius) {
  return std::sqrt(material.density / material.shear_modulus) * M_PI * radius /
         (0.1631 * material.poisson_ratio + 0.8766);
}

}  // namespace wheel_twin::dem
