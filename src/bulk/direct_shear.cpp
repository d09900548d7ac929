#include "bulk/direct_shear.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/progress.h"
#include "base/random.h"
#include "dem/archive.h"
#include "dem/cache.h"
#include "dem/cloud.h"
#include "dem/limits.h"
#include "dem/measures.h"
#include "dem/settle.h"
#include "dem/state_file.h"

namespace wheel_twin::bulk {
namespace {

using dem::GranularSoil;
using Eigen::Vector3d;

constexpr int method_version = 4;
constexpr double gravity = 9.81;
constexpr double cloud_density = 0.22;
constexpr double seating_stress = 20e3;  // Pa, the paper's lowest normal stress
constexpr double seating_time = 0.1;     // s
constexpr double headroom = 0.1;         // m over the cloud: a grain may be thrown up

// Numbers of the walls, in the order in which they are added.
enum Part : std::uint32_t { floor_plate, lower_frame, upper_frame, top_plate };

double solid_volume(const dem::System& system) {
  double volume = 0.0;
  for (std::size_t i = 0; i < system.size(); ++i) volume += system.mass(i);
  return volume / system.materials()[GranularSoil::grain_material].density;
}

dem::System box(const GranularSoil& soil, const ShearSettings& s, double top, bool with_plate) {
  const double flange = s.travel + 4.0 * soil.clumps.largest_bounding_radius();
  dem::WorldSettings world;
  world.low = {-flange, 0.0, -0.01};
  world.high = {s.length + flange, s.width, top};
  world.periodic_y = true;
  world.gravity = {0.0, 0.0, -gravity};
  world.step_fraction = soil.step_fraction;
  world.smallest_size = soil.clumps.smallest_size * (1.0 - 1e-6);  // sizes are rounded to single precision
  world.threads = s.threads;
  dem::System system(world, soil.materials(), soil.clumps.shapes);
  const auto add = [&](const char* name, auto shape, const Vector3d& position, std::int32_t surface = -1) {
    dem::Wall wall;
    wall.surface = surface;
    wall.name = name;
    wall.material = GranularSoil::wall_material;
    wall.shape = std::move(shape);
    wall.pose.position = position;
    system.add_wall(wall);
  };
  const Vector3d across(0.0, s.width, 0.0);
  const double below = 0.5 * (s.height - s.gap);
  const double above = 0.5 * (s.height + s.gap);
  const Vector3d rise_low(0.0, 0.0, below);
  const Vector3d rise_high(0.0, 0.0, top - above);
  add("floor", dem::HalfSpace{Vector3d::UnitZ()}, Vector3d::Zero());
  dem::Mesh lower = dem::parallelogram({0.0, 0.0, 0.0}, across, rise_low);
  append(lower, dem::parallelogram({s.length, 0.0, 0.0}, across, rise_low));
  append(lower, dem::parallelogram({-flange, 0.0, below}, across, {flange, 0.0, 0.0}));
  add("lower frame", lower, Vector3d::Zero(), 0);
  dem::Mesh upper = dem::parallelogram({0.0, 0.0, above}, across, rise_high);
  append(upper, dem::parallelogram({s.length, 0.0, above}, across, rise_high));
  append(upper, dem::parallelogram({s.length, 0.0, above}, across, {flange, 0.0, 0.0}));
  add("upper frame", upper, Vector3d::Zero(), 0);
  if (with_plate) add("top plate", dem::HalfSpace{-Vector3d::UnitZ()}, {0.0, 0.0, top});
  return system;
}

std::string sample_description(const GranularSoil& soil, const ShearSettings& s) {
  return fmt::format("shear sample {}\n{}void ratio {} box {} {} {} gap {} travel {} seed {}\n",
                     method_version, soil.fingerprint(), soil.shear_box_void_ratio, s.length, s.width,
                     s.height, s.gap, s.travel, s.seed);
}

// Fills the box at a friction; returns the system at rest.
dem::System filled_box(const GranularSoil& soil, const ShearSettings& s, double friction) {
  const double solid = s.length * s.width * s.height / (1.0 + soil.shear_box_void_ratio);
  const auto count = static_cast<std::size_t>(std::llround(solid / soil.clumps.mean_volume()));
  const double height = solid / (s.length * s.width * cloud_density);
  dem::System system = box(soil, s, height + headroom, false);
  Random random(s.seed);
  dem::CloudRegion region;
  region.low = {0.0, 0.0, 0.0};
  region.high = {s.length, s.width, height};
  region.periodic_y = true;
  system.add(random_cloud(soil.clumps, region, count, random, GranularSoil::grain_material));
  dem::PairProperties lowered = soil.grain_grain;
  lowered.friction = friction;
  system.set_pair(GranularSoil::grain_material, GranularSoil::grain_material, lowered);
  dem::SettleSettings fall;
  fall.shortest_time = std::sqrt(2.0 * std::max(0.0, height - s.height) / gravity);
  settle(system, fall);
  return system;
}

double highest_point(const dem::System& system) {
  double top = 0.0;
  for (const dem::SphereState& sphere : system.spheres())
    top = std::max(top, sphere.center.z() + sphere.radius);
  return top;
}

// Moves the top plate so that it carries the wanted force.
class Servo {
 public:
  Servo(dem::System& system, double area) : system_(&system) {
    // Gain: half of the force error is taken away in one interval when the sample is as stiff as a packing of
    // these grains may be: about a tenth of the grains' own modulus over the height of the plate. With a
    // fifth of that gain the plate lags behind a sample that dilates: 1 kPa at 20 mm/s.
    const double modulus = 0.1 * system.materials()[GranularSoil::grain_material].youngs_modulus();
    const double stiffness = modulus * area / system.wall(top_plate).pose.position.z();
    gain_ = 0.5 / (stiffness * interval * system.time_step());
  }
  static constexpr int interval = 10;  // steps

  void update(double wanted) {
    const double error = system_->wall_wrench(top_plate).force.z() - wanted;
    dem::Motion motion;
    motion.velocity.z() = std::clamp(gain_ * error, -0.1, 0.1);
    system_->set_wall_motion(top_plate, motion);
  }

 private:
  dem::System* system_;
  double gain_;
};

// The sample under the top plate, ready to consolidate.
dem::System plated_box(const GranularSoil& soil, const ShearSettings& s, dem::State state) {
  state.step = 0;
  dem::System probe = box(soil, s, 1.0, false);
  probe.restore(state);
  dem::System system = box(soil, s, highest_point(probe) + 1e-4, true);
  // The sample's contacts live on; its walls are those of a box without a plate.
  state.walls.clear();
  state.wall_removed.clear();
  for (std::uint32_t i = 0; i < system.wall_count(); ++i) {
    state.walls.push_back(system.wall(i));
    state.wall_removed.push_back(0);
  }
  system.restore(state);
  return system;
}

double void_ratio_of(const dem::System& system, const ShearSettings& s) {
  return s.length * s.width * system.wall(top_plate).pose.position.z() / solid_volume(system) - 1.0;
}

// Void ratio once the plate sits with the seating stress.
double seated_void_ratio(const GranularSoil& soil, const ShearSettings& s, const dem::State& state) {
  dem::System system = plated_box(soil, s, state);
  Servo servo(system, s.length * s.width);
  while (system.time() < seating_time) {
    servo.update(seating_stress * s.length * s.width);
    system.step(Servo::interval);
  }
  return void_ratio_of(system, s);
}

}  // namespace

ShearSample shear_sample(const GranularSoil& soil, const ShearSettings& s) {
  const dem::Archive archive = dem::fetch("shear_sample", sample_description(soil, s), [&] {
    const double target = 1.0 / (1.0 + soil.shear_box_void_ratio);
    const auto density = [&](double friction) {
      return 1.0 / (1.0 + seated_void_ratio(soil, s, filled_box(soil, s, friction).state()));
    };
    const double full = soil.grain_grain.friction;
    const double friction = density(full) >= target ? full : dem::tune_friction(target, full, 0.003, density);
    const dem::State state = filled_box(soil, s, friction).state();
    dem::Archive made;
    store(state, made);
    made.set_number("fill_friction", friction);
    made.set_number("void_ratio", seated_void_ratio(soil, s, state));
    return made;
  });
  ShearSample sample;
  sample.state = dem::load_state(archive);
  sample.clumps = sample.state.shape.size();
  sample.fill_friction = archive.number("fill_friction");
  sample.void_ratio = archive.number("void_ratio");
  return sample;
}

ShearCurve shear(const GranularSoil& soil, const ShearSample& sample, const ShearSettings& s,
                 double normal_stress, const std::function<void(double)>& progress) {
  dem::System system = plated_box(soil, s, sample.state);
  Servo servo(system, s.length * s.width);
  const double shear_time = s.travel / s.rate;
  const double total_time = s.consolidation_time + shear_time;
  const auto run = [&](double duration, const std::function<void()>& each) {
    const double end = system.time() + duration;
    while (system.time() < end) {
      const double travel = system.wall(lower_frame).pose.position.x();
      servo.update(normal_stress * (s.length - travel) * s.width);
      system.step(Servo::interval);
      if (each) each();
      if (progress) progress(system.time() / total_time);
    }
  };
  run(s.consolidation_time, {});

  ShearCurve curve;
  curve.normal_stress = normal_stress;
  const double plate_start = system.wall(top_plate).pose.position.z();
  curve.void_ratio_consolidated = void_ratio_of(system, s);
  dem::Motion motion;
  motion.velocity.x() = s.rate;
  system.set_wall_motion(floor_plate, motion);
  system.set_wall_motion(lower_frame, motion);
  double shear_sum = 0.0;
  double plate_sum = 0.0;
  int count = 0;
  double next = s.smoothing;
  run(shear_time, [&] {
    const double travel = system.wall(lower_frame).pose.position.x();
    const double area = (s.length - travel) * s.width;
    shear_sum -=
        (system.wall_wrench(floor_plate).force.x() + system.wall_wrench(lower_frame).force.x()) / area;
    plate_sum += system.wall_wrench(top_plate).force.z() / area;
    ++count;
    if (travel < next) return;
    curve.travel.push_back(travel - 0.5 * s.smoothing);
    curve.shear_stress.push_back(shear_sum / count);
    curve.plate_stress.push_back(plate_sum / count);
    curve.plate_rise.push_back(system.wall(top_plate).pose.position.z() - plate_start);
    shear_sum = plate_sum = 0.0;
    count = 0;
    next += s.smoothing;
  });
  if (curve.shear_stress.empty())
    throw Error("direct shear: the travel is shorter than the smoothing length");
  curve.peak_shear_stress = *std::max_element(curve.shear_stress.begin(), curve.shear_stress.end());
  const std::size_t tail = std::max<std::size_t>(1, curve.shear_stress.size() / 5);
  curve.final_shear_stress = std::accumulate(curve.shear_stress.end() - static_cast<std::ptrdiff_t>(tail),
                                             curve.shear_stress.end(), 0.0) /
                             static_cast<double>(tail);
  return curve;
}

double ShearResult::friction_angle() const {
  return std::atan(failure_line.slope);
}

double ShearResult::friction_angle_error() const {
  return failure_line.slope_error / (1.0 + failure_line.slope * failure_line.slope);
}

ShearResult direct_shear(const GranularSoil& soil, const ShearSettings& s) {
  if (s.normal_stresses.empty()) throw Error("direct shear: no normal stress is given");
  for (const double stress : s.normal_stresses)
    dem::check_positive("direct shear: normal stress (Pa)", stress);
  dem::check_positive("direct shear: rate (m/s)", s.rate, 1.0);
  dem::check_positive("direct shear: travel (m)", s.travel, 0.5 * s.length);
  dem::check_positive("direct shear: consolidation (s)", s.consolidation_time, 60.0);
  ShearResult result;
  result.sample = shear_sample(soil, s);
  Progress progress("direct shear", static_cast<double>(s.normal_stresses.size()));
  std::vector<double> peaks;
  for (const double normal_stress : s.normal_stresses) {
    const auto before = static_cast<double>(result.curves.size());
    result.curves.push_back(shear(soil, result.sample, s, normal_stress,
                                  [&](double fraction) { progress.update(before + fraction); }));
    peaks.push_back(result.curves.back().peak_shear_stress);
  }
  if (s.normal_stresses.size() > 1) {
    result.failure_line = fit_line(s.normal_stresses, peaks);
  } else {
    result.failure_line.slope = peaks[0] / s.normal_stresses[0];  // one test: through the origin
  }
  return result;
}

}  // namespace wheel_twin::bulk
