#include "cosim/dem_contact.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "cosim/checkpoint.h"
#include "cosim/wheel_faces.h"
#include "dem/archive.h"

namespace wheel_twin::cosim {
namespace {

/// Acceleration of the tip of a segment (of its grouser, where wheels have them) under a force there, 1/kg.
double tip_mobility(const wheel::FlexibleWheel& wheel) {
  const wheel::WheelModel& model = wheel.model();
  if (model.suspension == wheel::Suspension::rigid) return 0.0;
  const double mass = wheel.rim_mass() / model.segments;
  const double length = 2.0 * M_PI * model.radius / model.segments;
  const double arm = std::hypot(0.5 * length, model.grousers > 0 ? model.grouser_height : 0.0);
  return 1.0 / mass + arm * arm / (mass * length * length / 12.0);
}

DemSoilSettings bed_settings(const DemSettings& s, int threads, bool track_energy, double rig_step) {
  DemSoilSettings settings;
  settings.start_x = s.start_x;
  settings.rig_step = rig_step;
  settings.headroom = s.headroom;
  settings.threads = threads;
  settings.step_fraction = s.step_fraction;
  settings.sleep = s.sleep;
  settings.window = s.window;
  settings.track_energy = track_energy;
  return settings;
}

}  // namespace

DemSoil soil_under(const wheel::WheelModel& model, const dem::GranularSoil& soil, const dem::Bed& bed,
                   const DemSettings& settings, const rig::Ports& ports, int threads, bool track_energy,
                   double rig_step) {
  const wheel::FlexibleWheel wheel(model);
  const double reach = outermost_radius(wheel);
  if (model.width >= settings.bed.width || 2.0 * reach >= settings.bed.length)
    throw Error(fmt::format(
        "dem settings '{}': a bed of {} x {} m is too small for wheel '{}', {:.3f} m in diameter and {} m "
        "wide",
        settings.name, settings.bed.length, settings.bed.width, model.name, 2.0 * reach, model.width));
  if (settings.window && std::min(settings.window->behind, settings.window->ahead) < reach)
    throw Error(
        fmt::format("dem settings '{}': a window of {} m behind and {} m ahead of the hub is too small for "
                    "wheel '{}', {:.3f} m in radius",
                    settings.name, settings.window->behind, settings.window->ahead, model.name, reach));
  if (!settings.bed.periodic_x &&
      (settings.start_x < reach || settings.start_x + reach > settings.bed.length))
    throw Error(fmt::format("dem settings '{}': a wheel at start_x {} m stands in a wall of the bed",
                            settings.name, settings.start_x));
  DemSoilSettings of_soil = bed_settings(settings, threads, track_energy, rig_step);
  of_soil.rim_mobility = tip_mobility(wheel);
  return {soil, bed, segment_shapes(wheel), of_soil, ports.soil};
}

double start_clearance(const DemSoil& soil, const wheel::FlexibleWheel& wheel, const rig::Ports& ports) {
  constexpr double gap = 1e-4;  // m
  return soil.first_touch(0.0, outermost_radius(wheel), wheel.model().width) - rim_radius(wheel) +
         rig::hub_rise(ports, rig::RigState()) + gap;
}

DemContact::DemContact(const wheel::WheelModel& wheel, const dem::GranularSoil& soil,
                       const DemSettings& settings, const rig::Ports& ports, int threads, bool track_energy,
                       double rig_step)
    : DemContact(wheel, scaled_soil(soil, settings),
                 dem::fetch_bed(scaled_soil(soil, settings), settings.bed, threads), settings, ports, threads,
                 track_energy, rig_step) {}

DemContact::DemContact(const wheel::WheelModel& wheel, const dem::GranularSoil& soil, const dem::Bed& bed,
                       const DemSettings& settings, const rig::Ports& ports, int threads, bool track_energy,
                       double rig_step)
    : report_(bed.report),
      soil_(soil_under(wheel, soil, bed, settings, ports, threads, track_energy, rig_step)),
      coupled_(wheel, soil_, ports),
      clearance_(start_clearance(soil_, coupled_.wheel(), ports)) {}

void DemContact::write_checkpoint(const std::string& path) const {
  dem::Archive archive = soil_archive(soil_);
  store(coupled_.state(), archive);
  dem::write_archive(path, checkpoint_kind, archive);
}

void DemContact::resume(const std::string& path) {
  const dem::Archive archive = dem::read_archive(path, checkpoint_kind);
  CouplingState state = load_coupling(archive, path, coupled_.segments().size());
  restore_soil(archive, path, soil_);
  coupled_.resume(std::move(state));
}

}  // namespace wheel_twin::cosim
