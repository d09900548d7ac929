// A wheel as its YAML describes it: geometry, sheet metal, how the rim hangs on the hub, damping. Paper,
// Sections 6.2 (AMALIA: radial springs) and 8 (T0-R0: semicircular beams). SI units. Angles around the rim
// count from the top of the unturned wheel towards +x, the sense in which the wheel rolls.
#pragma once

#include <string>
#include <vector>

#include "base/yaml.h"

namespace wheel_twin::wheel {

enum class Suspension {
  rigid,    ///< the rim is one body with the hub
  springs,  ///< spring-dampers between hub and rim, one a beam (paper, Section 6.2)
  beams     ///< semicircular beams discretised in bodies (paper, Section 8)
};

/// How a sheet's bending stiffness becomes that of a torsion spring between two segments.
enum class Bending {
  beam,    ///< E I / L: the spring turns as a segment of length L bends
  plate,   ///< E I / ((1 - nu^2) L): the same for a strip too wide for anticlastic bending
  printed  ///< the paper's procedure: ring taken for an ellipse, half the energy (`calibration.h`)
};

struct Sheet {
  double thickness = 0.0004;       ///< m
  double width = 0.07;             ///< m, along the axle
  double density = 7850.0;         ///< kg/m^3
  double young_modulus = 200.0e9;  ///< Pa
  double poisson_ratio = 0.3;
  double flexural_rigidity() const;  ///< E I, N m^2
};

struct Springs {
  int positions = 16;                 ///< around the rim
  int sets = 2;                       ///< at every position, side by side along the axle
  double radial_stiffness = 4980.0;   ///< N/m, each
  double tangential_stiffness = 0.0;  ///< N/m, each
  double tangential_depth = 0.0;   ///< m inward from the rim: where the tangential spring holds the segment
  double turning_stiffness = 0.0;  ///< N m/rad, each, against the segment's turning relative to the hub
};

struct Beams {
  int positions = 16;
  int sets = 2;                  ///< side by side along the axle, curled to alternating sides
  int bodies = 12;               ///< a beam
  Sheet sheet;                   ///< width is that of one beam
  double joint_stiffness = 0.0;  ///< torsion spring between two bodies, N m/rad
};

/// A spring or beam that differs from the others: stiffness times `factor`; 0 is a missing one.
struct Fault {
  int position = 0;
  int set = 0;
  double factor = 1.0;
};

struct WheelModel {
  std::string name = "wheel";
  double radius = 0.09;  ///< m, middle of the rim sheet
  double width = 0.07;   ///< m
  int grousers = 0;
  double grouser_height = 0.0;       ///< m above the rim's outer face
  double grouser_thickness = 0.001;  ///< m
  Suspension suspension = Suspension::rigid;
  int segments = 64;  ///< of the rim; even, 24 to 256
  Sheet rim;
  Bending bending = Bending::beam;
  double rim_joint_stiffness = 0.0;  ///< torsion spring between two segments, N m/rad
  double hub_radius = 0.035;         ///< m, where springs or beams are clamped
  double hub_mass = 1.0;             ///< kg, matters only where the hub is free
  double hub_inertia = 1.0e-3;       ///< kg m^2 about the axle
  Springs springs;
  Beams beams;
  std::vector<Fault> faults;
  /// Dampers proportional to the springs: this ratio of critical damping at this frequency.
  double damping_ratio = 0.0;
  double damping_frequency = 180.0;  ///< Hz
  int max_substeps = 4;              ///< step() takes as few as stability asks, up to this
};

/// The longest rim segment's length, m: chord between two joints on the circle of `radius`.
double segment_length(const WheelModel& model);

/// Reads a wheel file (config/wheels/*.yaml): the keys of `terramechanics::read_wheel` and the section
/// `multibody`; without that section the wheel is rigid. Throws Error naming file, line, key and limit.
WheelModel read_wheel_model(const yaml::Map& map);
WheelModel read_wheel_file(const std::string& path);

/// Throws Error with the limit where a value makes no wheel: an odd segment count, zero thickness, negative
/// stiffness.
void check(const WheelModel& model);

}  // namespace wheel_twin::wheel
