#include "cosim/soil_change.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "cosim/emergent.h"

namespace wheel_twin::cosim {
namespace {

constexpr int most_levels = 18;        // the engine takes 22 materials
constexpr double least_factor = 0.02;  // of stiffness
constexpr double hardest = 50.0;       // factor from which on soil counts as rigid
constexpr double behind = 0.05;        // m, of the start: where a periodic bed is cut to be laid out

/// The ports' answers where the rig stands at `x`.
struct Asked {
  const std::vector<const rig::SoilPort*>& ports;

  static rig::RigState state_at(double x) {
    rig::RigState state;
    state.x = x;
    return state;
  }
  double factor(double x, double depth) const {
    double product = 1.0;
    for (const rig::SoilPort* port : ports)
      product *= port->stiffness_factor(state_at(x)) * port->layer_factor(state_at(x), depth);
    return product;
  }
  double cohesion() const {
    double sum = 0.0;
    for (const rig::SoilPort* port : ports) sum += port->added_cohesion(state_at(0.0));
    return sum;
  }
  double slope() const {
    double sum = 0.0;
    for (const rig::SoilPort* port : ports) sum += port->surface_slope(state_at(0.0));
    return sum;
  }
};

/// Energy density of the attraction that gives the bed a cohesion, J/m^3. Rumpf: sigma_t = phi Z F / (pi d^2)
/// with the force F of a contact, whose area at the overlap of the bed's own weight at `depth` is
/// 2 pi R delta.
double attraction(const dem::GranularSoil& soil, const dem::Bed& bed, double cohesion) {
  if (!(bed.report.coordination.per_clump > 0.0))
    throw Error(
        "fidelity dem: an effect adds cohesion to a bed too small to count the contacts of its grains");
  const double radius = soil.clumps.smallest_radius() / soil.clumps.smallest_size;
  const double diameter = std::cbrt(6.0 * soil.clumps.mean_volume() / M_PI);
  const double tensile = cohesion / soil.grain_grain.friction;
  const double force =
      tensile * M_PI * diameter * diameter / (soil.packing_density * bed.report.coordination.per_clump);
  // F = k 2 pi R_eq delta and Hertz give k for a contact that the attraction alone would hold together.
  const double reduced_radius = 0.5 * radius;
  const double modulus =
      soil.grain.youngs_modulus() / (2.0 * (1.0 - soil.grain.poisson_ratio * soil.grain.poisson_ratio));
  const double stress = soil.grain.density * soil.packing_density * bed.settings.gravity * 0.03;
  const double carried =
      stress * M_PI * diameter * diameter / (soil.packing_density * bed.report.coordination.per_clump);
  const double overlap =
      std::pow(0.75 * (force + carried) / (modulus * std::sqrt(reduced_radius)), 2.0 / 3.0);
  return force / (2.0 * M_PI * reduced_radius * overlap);
}

}  // namespace

ChangedBed change_bed(const dem::GranularSoil& soil, const dem::Bed& bed, double start_x,
                      const std::vector<const rig::SoilPort*>& ports) {
  const Asked asked{ports};
  ChangedBed changed;
  changed.state = bed.state;
  changed.slope = asked.slope();
  refuse_what_emerges(ports);

  const bool periodic = bed.settings.periodic_x;
  const double length = bed.settings.length;
  const auto laid_out = [&](double x_bed) {
    const double x = x_bed - start_x;
    return periodic && x < -behind ? x + length : x;
  };
  for (int i = 0; periodic && i <= 100; ++i) {
    const double x = -behind + 0.01 * i * length;
    if (asked.factor(x, 0.0) != asked.factor(-behind, 0.0)) changed.good_until = length - behind;
  }

  // Factor of every grain, and the levels between the extremes.
  std::vector<double> logarithm(changed.state.position.size());
  double lowest = 1e30;
  double highest = -1e30;
  for (std::size_t i = 0; i < logarithm.size(); ++i) {
    const Eigen::Vector3d& p = changed.state.position[i];
    const double x = laid_out(p.x());
    const double factor = asked.factor(x, std::max(0.0, -p.z()));
    if (!(factor >= least_factor))
      throw Error(fmt::format(
          "fidelity dem: a stiffness factor of {:.3g} at x = {:.3f} m, {:.3f} m deep, is below {}", factor, x,
          -p.z(), least_factor));
    logarithm[i] = std::log(std::min(factor, hardest));
    lowest = std::min(lowest, logarithm[i]);
    highest = std::max(highest, logarithm[i]);
  }
  const double range = highest - lowest;
  const bool uniform = range < 1e-12;
  const int levels = uniform ? 1 : most_levels;
  const double step = levels > 1 ? range / (levels - 1) : 1.0;
  dem::PairProperties pair = soil.grain_grain;
  const double cohesion = asked.cohesion();
  if (cohesion > 0.0) pair.cohesion_energy_density += attraction(soil, bed, cohesion);
  for (int level = 0; level < levels; ++level) {
    dem::Material grain = soil.grain;
    const double factor = std::exp(lowest + level * step);
    grain.density *= factor;
    grain.shear_modulus *= factor;
    if (levels > 1) grain.name += fmt::format(" {}", level);
    changed.materials.add(grain);
  }
  const std::uint32_t wall = changed.materials.add(soil.wall);
  for (std::uint32_t a = 0; a < wall; ++a) {
    for (std::uint32_t b = a; b < wall; ++b) changed.materials.set_pair(a, b, pair);
    changed.materials.set_pair(a, wall, soil.grain_wall);
  }
  changed.grain_materials = wall;
  for (std::size_t i = 0; i < logarithm.size(); ++i)
    changed.state.material[i] = static_cast<std::uint32_t>(std::lround((logarithm[i] - lowest) / step));
  for (dem::Wall& w : changed.state.walls) w.material = wall;
  changed.changed = !uniform || lowest != 0.0 || cohesion > 0.0 || changed.slope != 0.0;
  return changed;
}

}  // namespace wheel_twin::cosim
