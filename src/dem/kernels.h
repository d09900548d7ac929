// The inner loops of a step, compiled for several instruction sets (Highway) and chosen at run time. Each
// works on a range, so that threads share the work; what one range adds to a body's load is exact in any
// order (see Quanta).
#pragma once

#include <cstddef>
#include <cstdint>

#include "dem/contact_law.h"
#include "dem/store.h"

namespace wheel_twin::dem {

/// Contributions to forces and torques are rounded to multiples of these powers of two: sums of up to 2^53
/// quanta are then exact, whatever their order. A rounding to quantum Q is (f + M) - M with M = 1.5 * 2^52 Q.
struct Quanta {
  double force_magic = 0.0;
  double torque_magic = 0.0;
};

struct Period {
  double length[3] = {0.0, 0.0, 0.0};   ///< m
  double inverse[3] = {0.0, 0.0, 0.0};  ///< 0 on axes that are not periodic
  double low[3] = {0.0, 0.0, 0.0};
  double high[3] = {0.0, 0.0, 0.0};
};

/// Templates as tables: 16 entries a shape.
struct ShapeTable {
  Column<double> x, y, z, radius;
  /// The same, kBatch templates a row, entry kBatch * sphere + template: empty when there are more.
  Column<double> few[4];
  Column<std::uint8_t> count;
  int largest_count = 1;
};

struct MotionTask {
  Bodies* bodies = nullptr;
  Spheres* spheres = nullptr;
  const ShapeTable* shapes = nullptr;
  const Period* period = nullptr;
  double time_step = 0.0;
  double gravity[3] = {0.0, 0.0, 0.0};
  std::size_t awake_end = ~std::size_t{0};  ///< bodies from here on do not move
};

struct MotionResult {
  float smallest_slack = 1e30F;  ///< negative or not a number: the inner list is no longer good
  bool outside = false;  ///< some body is outside the domain on an axis that is not periodic, or not a number
};

struct ContactTask {
  PairList* pairs = nullptr;
  const Spheres* spheres = nullptr;
  Bodies* bodies = nullptr;
  const LawTable* laws = nullptr;
  const Period* period = nullptr;
  Quanta quanta;
  ContactLaw law;
  double time_step = 0.0;
  float* trace = nullptr;  ///< energy book: Trace::kColumns columns of `trace_stride`
  std::size_t trace_stride = 0;
};

/// What the energy book wants to know of a contact (of a relative to b).
struct Trace {
  static constexpr int kVelocity = 0;  ///< 3 columns, at the contact point, m/s
  static constexpr int kForce = 3;     ///< 3 columns, on a, N
  static constexpr int kNormal = 6;    ///< 3 columns
  static constexpr int kDamping = 9;   ///< damping part of the normal force, N
  static constexpr int kSpin = 10;     ///< 3 columns, angular velocity, rad/s
  static constexpr int kMoment = 13;   ///< 3 columns, that resists rolling, on a, N m
  static constexpr int kColumns = 16;
};

struct ContactResult {
  std::size_t touching = 0;
  float worst = -1.0F;  ///< largest overlap over the smaller radius, minus the limit; above 0 is an error
};

/// Contacts with walls, found before the kernel runs: sphere against a point of a surface.
struct WallContacts {
  std::size_t size = 0;  ///< entries; the arrays are padded to a batch
  Column<std::uint32_t> sphere;
  Column<double> normal[3];   ///< from the wall to the sphere
  Column<double> distance;    ///< from the surface to the sphere's centre, m
  Column<float> velocity[3];  ///< of the wall there, m/s
  Column<float> spin[3];      ///< of the wall, rad/s
  Column<float> stiffness, damping;
  Column<std::uint8_t> law;
  Column<float> shear[3], overlap, rolling[3];  ///< history, replaced
  Column<double> force[3];                      ///< on the sphere, rounded; output
  Column<float> moment[3];  ///< that resists rolling, on the sphere; output, only with rolling friction
  void resize(std::size_t entries, bool rolls);
};

struct WallTask {
  WallContacts* contacts = nullptr;
  const Spheres* spheres = nullptr;
  Bodies* bodies = nullptr;
  const LawTable* laws = nullptr;
  Quanta quanta;
  ContactLaw law;
  double time_step = 0.0;
  float* trace = nullptr;
  std::size_t trace_stride = 0;
};

/// Deepest overlap allowed, as a fraction of the smaller radius.
constexpr float kDeepestOverlap = 0.5F;

/// Kick, drift, rotation and new sphere rows of the bodies [begin, end); both multiples of kBatch. Loads are
/// cleared.
MotionResult move_bodies(const MotionTask& task, std::size_t begin, std::size_t end);
/// Sphere rows of the bodies [begin, end) from their present positions; nothing else changes.
void place_spheres(const MotionTask& task, std::size_t begin, std::size_t end);
/// Contact forces of the pairs [begin, end), both multiples of kBatch; adds to the bodies' loads, renews
/// histories.
ContactResult evaluate_pairs(const ContactTask& task, std::size_t begin, std::size_t end);
/// The same for contacts with walls.
ContactResult evaluate_walls(const WallTask& task);

/// Name of the instruction set that the kernels use here.
const char* instruction_set();

}  // namespace wheel_twin::dem
