// The soil side of the co-simulation: a settled bed in the discrete-element engine with the wheel's segments
// as walls of one surface. The bed's x runs from 0; the rig's x = 0 stands at `start_x` in it. On a slope the
// bed's axes are turned about y against the rig's, gravity stays vertical in the rig. SI units.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "cosim/soil_side.h"
#include "dem/bed.h"
#include "dem/granular_soil.h"
#include "dem/system.h"
#include "rig/ports.h"

namespace wheel_twin::cosim {

struct ChangedBed;

/// The part of a bed that moves with the wheel: what lies farther behind the hub or ahead of it is held
/// still.
struct BedWindow {
  double behind = 0.0;  ///< m
  double ahead = 0.0;   ///< m
};

struct DemSoilSettings {
  double start_x = 0.12;    ///< place of the rig's x = 0 in the bed, m
  double rig_step = 0.001;  ///< s, of which the soil's step is a whole fraction
  double headroom = 0.3;    ///< of the domain above the surface, m
  int threads = 1;
  std::optional<double> step_fraction;  ///< of the Rayleigh time; none: the soil's
  dem::SleepSettings sleep;             ///< of the bed's still parts
  std::optional<BedWindow> window;      ///< none: the whole bed moves
  /// What a force on a rim segment's outermost point gives its acceleration there, 1 / kg: shortens the step
  /// where hard-pressed grains would shake a light rim. 0: a wheel that they cannot shake.
  double rim_mobility = 0.0;
  bool track_energy = false;  ///< the engine's energy book; slower
};

class DemSoil final : public SoilSide {
 public:
  /// Soil ports act on the bed once, now. Throws Error when they ask for what this soil cannot do.
  DemSoil(const dem::GranularSoil& soil, const dem::Bed& bed, const std::vector<wheel::SegmentShape>& wheel,
          const DemSoilSettings& settings, const std::vector<const rig::SoilPort*>& ports = {});

  double time_step() const override { return system_.time_step(); }
  std::size_t segment_count() const { return loads_.size(); }
  const std::vector<wheel::Wrench>& advance(std::int64_t step,
                                            const std::vector<wheel::SegmentState>& segments) override;

  /// Lowest height of a hub at rig position `x` at which no grain touches a cylinder of `radius` and `width`
  /// about the axle, rig axes, m.
  double first_touch(double x, double radius, double width) const;

  const dem::System& system() const { return system_; }
  /// State of the engine; walls of the wheel included. Restoring continues with identical bits.
  dem::State state() const { return system_.state(); }
  void restore(const dem::State& state) { system_.restore(state); }
  std::string fingerprint() const;  ///< what a state must agree with

  Eigen::Vector3d to_rig(const Eigen::Vector3d& point_bed) const;  ///< a point
  Eigen::Vector3d to_bed(const Eigen::Vector3d& point_rig) const;

 private:
  DemSoil(const dem::GranularSoil& soil, const dem::Bed& bed, const ChangedBed& changed,
          const std::vector<wheel::SegmentShape>& wheel, const DemSoilSettings& settings);

  Eigen::Matrix3d bed_from_rig_;
  double start_x_ = 0.0;
  std::optional<BedWindow> window_;
  double good_until_ = 0.0;
  dem::System system_;
  std::uint32_t first_wall_ = 0;
  std::vector<wheel::Wrench> loads_;
};

}  // namespace wheel_twin::cosim
