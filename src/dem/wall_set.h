// The walls of a world: their motion, which spheres are near which face, and which of several touched faces
// count. A face's closest point that lies on a deeper touched face of the same surface is the same contact (a
// shared edge, the next triangle of a flat side) and is dropped; the tangential spring of a contact that
// vanished passes to a new one on the same surface.
#pragma once

#include <cstdint>
#include <vector>

#include "dem/facets.h"
#include "dem/kernels.h"
#include "dem/neighbours.h"
#include "dem/system.h"

namespace wheel_twin::dem {

class WallSet {
 public:
  struct Part {
    Wall wall;
    std::vector<Facet> facets;
    double radius = 0.0;    ///< largest distance of a vertex from the reference point, m
    double slack = 0.0;     ///< way left before the inner list is to be made, m
    double reserve = 0.0;   ///< further way before the outer list is to be made, m
    double wrench[6] = {};  ///< on the wall, exact sums of quanta
    double booked[6] = {};  ///< wrench when the energy book last looked
    bool removed = false;
    bool placed = false;  ///< set_pose gave the pose of the next step
    bool moved = false;   ///< since near_moved() looked last
    /// Its pose changes in the next step.
    bool moves() const {
      return placed || !wall.motion.velocity.isZero(0.0) || !wall.motion.angular_velocity.isZero(0.0);
    }
  };
  /// A touched face, kept from step to step.
  struct Touch {
    std::uint32_t sphere, part, facet;
    float shear[3], overlap, rolling[3];
  };

  std::uint32_t add(const Wall& wall);
  void remove(std::uint32_t wall);
  void set_pose(std::uint32_t wall, const Pose& pose, const Motion& motion);
  void set_motion(std::uint32_t wall, const Motion& motion);
  void set_mesh(std::uint32_t wall, const Mesh& mesh);
  std::vector<Part>& parts() { return parts_; }
  const std::vector<Part>& parts() const { return parts_; }

  /// Moves every wall by one step. Returns the smallest slack.
  double advance(double time_step);
  /// Gives every wall a skin for `steps` steps, out of its reserve; false when a reserve is too small.
  bool allot(double time_step, int steps, double least);
  void refill(double time_step, int steps, double least);

  /// For every point: is it nearer than `range` to a wall that moved since the last call?
  std::vector<bool> near_moved(const std::vector<Eigen::Vector3d>& points, double range,
                               const Period& period);

  /// Faces near spheres, by thread; spheres are near when nearer than radius, the body's reserve and the
  /// wall's.
  void find_outer(const Bodies& bodies, const Spheres& spheres, const Period& period,
                  const ThreadBounds& bounds);
  /// Those within the slacks.
  void find_inner(std::size_t thread, const Bodies& bodies, const Spheres& spheres, const Period& period,
                  const PairCoefficients& coefficients);
  /// Touched faces of the thread's spheres as contacts for the kernel.
  void collect(std::size_t thread, const Spheres& spheres, const Period& period, bool rolls);
  /// After the kernel: histories back, wrenches summed.
  void finish(std::size_t thread, const Quanta& quanta, bool rolls);
  void sum_wrenches();  ///< over the threads

  WallContacts& contacts(std::size_t thread) { return threads_[thread].contacts; }
  const WallContacts& contacts(std::size_t thread) const { return threads_[thread].contacts; }
  /// Columns of the trace of this step's contacts, for the energy book.
  Column<float>& trace(std::size_t thread) { return threads_[thread].trace; }
  std::vector<Touch>& touches(std::size_t thread) { return threads_[thread].touches; }
  const std::vector<Touch>& touches(std::size_t thread) const { return threads_[thread].touches; }
  std::size_t threads() const { return threads_.size(); }
  /// Takes the histories out, and puts them back after the spheres were renumbered; any order.
  std::vector<Touch> take_touches();
  void put_touches(std::vector<Touch> touches, const Spheres& spheres, const ThreadBounds& bounds);
  std::size_t bytes() const;

 private:
  struct Candidate {
    std::uint32_t sphere, surface, part, facet;
    float stiffness, damping;
    std::uint8_t law;
  };
  struct Thread {
    std::vector<Candidate> outer, inner;
    std::vector<Touch> touches, before;
    WallContacts contacts;
    Column<float> trace;
    std::vector<double> wrench;  ///< 6 a part: force, torque
    std::vector<Eigen::Vector3d> point;
    // Of the touched faces, one entry each; kept from step to step for their memory.
    std::vector<const Candidate*> chosen;
    std::vector<ClosestPoint> where;
  };
  struct Found;
  void resolve(Thread& thread, std::size_t begin, std::size_t end, const Spheres& spheres,
               const Period& period, std::vector<Found>& found) const;
  void measure(Part& part) const;
  std::uint32_t surface_of(std::uint32_t part) const;

  std::vector<Part> parts_;
  std::vector<Thread> threads_;
};

}  // namespace wheel_twin::dem
