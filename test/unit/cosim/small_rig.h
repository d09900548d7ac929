// A wheel of 80 mm on a bed of some 400 clumps: a co-simulation of seconds.
#pragma once

#include <cstdlib>
#include <memory>
#include <string>

#include "cosim/coupled_contact.h"
#include "cosim/dem_soil.h"
#include "cosim/wheel_faces.h"
#include "dem/bed.h"
#include "dem/granular_soil.h"
#include "rig/free_run.h"

namespace wheel_twin::cosim::test {

inline wheel::WheelModel small_wheel(wheel::Suspension suspension = wheel::Suspension::springs) {
  wheel::WheelModel model;
  model.name = "small";
  model.radius = 0.04;
  model.width = 0.03;
  model.segments = 32;
  model.suspension = suspension;
  model.rim.thickness = 0.0003;
  model.rim.width = model.width;
  model.rim_joint_stiffness = 3.0;
  model.hub_radius = 0.015;
  model.springs.positions = 8;
  model.springs.sets = 2;
  model.springs.radial_stiffness = 1500.0;
  model.springs.tangential_stiffness = 1500.0;
  model.damping_ratio = 0.02;
  return model;
}

inline const dem::GranularSoil& soil() {
  static const dem::GranularSoil loaded = dem::load_granular_soil("mars_simulant");
  return loaded;
}

inline const dem::Bed& small_bed() {
  static const dem::Bed bed = [] {
    dem::BedSettings settings;
    settings.length = 0.15;
    settings.width = 0.06;
    settings.depth = 0.03;
    settings.fill_friction = 0.5;
    return dem::make_bed(soil(), settings, 1);
  }();
  return bed;
}

inline std::vector<wheel::SegmentShape> shapes_of(const wheel::WheelModel& model) {
  return segment_shapes(wheel::FlexibleWheel(model));
}

/// Soil and contact of a run, and the rig's settings for it.
struct SmallRun {
  DemSoil dem;
  CoupledContact contact;
  rig::Ports ports;
  rig::RunSettings settings;

  explicit SmallRun(int threads = 1, bool track_energy = false,
                    const wheel::WheelModel& model = small_wheel(), rig::Ports acting = {},
                    std::optional<BedWindow> window = {})
      : dem(soil(), small_bed(), shapes_of(model), soil_settings(threads, track_energy, window), acting.soil),
        contact(model, dem, acting),
        ports(std::move(acting)) {
    settings.radius = contact.radius();
    settings.conditions.load = 4.0;
    settings.conditions.slip = 0.4;
    settings.conditions.wheel_speed = 1.5;
    settings.rig.slide.viscous_damping = 10.0;
    settings.rig.mount.tool_mass = 0.2;
    settings.profile.clearance =
        dem.first_touch(0.0, contact.radius() + 0.001, model.width) - contact.radius() + 1e-4;
    settings.profile.lowering_speed = 0.1;
    settings.profile.dwell = 0.0;
    settings.profile.travel = 0.0;
    settings.profile.longest_steady = 0.3;
    settings.profile.rest = 0.0;
  }

  static DemSoilSettings soil_settings(int threads, bool track_energy, std::optional<BedWindow> window = {}) {
    DemSoilSettings settings;
    settings.start_x = 0.05;
    settings.headroom = 0.2;
    settings.threads = threads;
    settings.track_energy = track_energy;
    settings.window = window;
    return settings;
  }
};

}  // namespace wheel_twin::cosim::test
