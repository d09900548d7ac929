// Wheel and discrete-element soil in one process behind the rig's contact interface, with checkpoints. What
// `twin run --fidelity dem` runs on. Frame `rig`, SI units.
#pragma once

#include <memory>
#include <string>

#include "cosim/coupled_contact.h"
#include "cosim/dem_settings.h"
#include "cosim/dem_soil.h"
#include "rig/contact.h"
#include "rig/ports.h"
#include "wheel/wheel_model.h"

namespace wheel_twin::cosim {

/// The soil for a wheel: `soil` as scaled by `settings`, and its bed. Throws Error when wheel, soil, bed and
/// the soil's ports do not go together.
DemSoil soil_under(const wheel::WheelModel& model, const dem::GranularSoil& soil, const dem::Bed& bed,
                   const DemSettings& settings, const rig::Ports& ports, int threads,
                   bool track_energy = false, double rig_step = 0.001);

/// Height of the hub above its first touch with a level surface (rig z = 0) at which a run can start, m: no
/// grain touches the wheel, grousers included, where its ports put it.
double start_clearance(const DemSoil& soil, const wheel::FlexibleWheel& wheel, const rig::Ports& ports);

class DemContact final : public rig::Contact {
 public:
  /// Fetches the bed (or makes it, which takes minutes). What `ports` point to must outlive the contact.
  /// Throws Error when wheel, soil, bed and effects do not go together.
  DemContact(const wheel::WheelModel& wheel, const dem::GranularSoil& soil, const DemSettings& settings,
             const rig::Ports& ports, int threads, bool track_energy = false, double rig_step = 0.001);

  rig::HubLoad advance(const rig::HubMotion& motion) override { return coupled_.advance(motion); }

  /// start_clearance of the bed as it was made, m; a restored state does not change it.
  double clearance() const { return clearance_; }

  /// Soil, wheel and the answers so far, so that a run taken up from there goes on with identical bits.
  void write_checkpoint(const std::string& path) const;
  /// Before the first advance(). Throws Error naming the file when it does not fit.
  void resume(const std::string& path);

  const DemSoil& soil() const { return soil_; }
  const CoupledContact& coupled() const { return coupled_; }
  const dem::BedReport& bed_report() const { return report_; }

 private:
  DemContact(const wheel::WheelModel& wheel, const dem::GranularSoil& soil, const dem::Bed& bed,
             const DemSettings& settings, const rig::Ports& ports, int threads, bool track_energy,
             double rig_step);

  dem::BedReport report_;
  DemSoil soil_;
  CoupledContact coupled_;
  double clearance_ = 0.0;
};

}  // namespace wheel_twin::cosim
