#include "cosim/dem_contact.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"
#include "cosim/wheel_faces.h"
#include "dem/archive.h"
#include "dem/state_file.h"

namespace wheel_twin::cosim {
namespace {

constexpr const char* kind = "co-simulation";

std::vector<wheel::SegmentShape> shapes_of(const wheel::WheelModel& model) {
  const wheel::FlexibleWheel wheel(model);
  std::vector<wheel::SegmentShape> shapes;
  for (int i = 0; i < wheel.segment_count(); ++i) shapes.push_back(wheel.shape(i));
  return shapes;
}

DemSoilSettings soil_settings(const DemSettings& s, int threads, bool track_energy, double rig_step) {
  DemSoilSettings settings;
  settings.start_x = s.start_x;
  settings.rig_step = rig_step;
  settings.headroom = s.headroom;
  settings.threads = threads;
  settings.track_energy = track_energy;
  return settings;
}

void put(std::vector<double>& out, const Eigen::Vector3d& v) {
  out.insert(out.end(), {v.x(), v.y(), v.z()});
}

Eigen::Vector3d take(const double*& in) {
  const Eigen::Vector3d v(in[0], in[1], in[2]);
  in += 3;
  return v;
}

constexpr std::size_t motion_numbers = 10;
constexpr std::size_t answer_numbers = 8;

std::vector<double> numbers_of(const rig::HubMotion& m) {
  std::vector<double> out{m.time, m.wheel_angle, m.wheel_rate, m.steering_angle};
  put(out, m.position);
  put(out, m.velocity);
  return out;
}

rig::HubMotion motion_of(const std::vector<double>& numbers) {
  const double* in = numbers.data();
  rig::HubMotion m;
  m.time = *in++;
  m.wheel_angle = *in++;
  m.wheel_rate = *in++;
  m.steering_angle = *in++;
  m.position = take(in);
  m.velocity = take(in);
  return m;
}

}  // namespace

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
      soil_(soil, bed, shapes_of(wheel), soil_settings(settings, threads, track_energy, rig_step),
            ports.soil),
      coupled_(wheel, soil_, ports) {
  const double reach = outermost_radius(coupled_.wheel());
  if (wheel.width >= settings.bed.width || 2.0 * reach >= settings.bed.length)
    throw Error(fmt::format(
        "dem settings '{}': a bed of {} x {} m is too small for wheel '{}', {:.3f} m in diameter and {} m "
        "wide",
        settings.name, settings.bed.length, settings.bed.width, wheel.name, 2.0 * reach, wheel.width));
  if (!settings.bed.periodic_x &&
      (settings.start_x < reach || settings.start_x + reach > settings.bed.length))
    throw Error(fmt::format("dem settings '{}': a wheel at start_x {} m stands in a wall of the bed",
                            settings.name, settings.start_x));
}

double DemContact::clearance() const {
  constexpr double gap = 1e-4;  // m
  const wheel::FlexibleWheel& wheel = coupled_.wheel();
  return soil_.first_touch(0.0, outermost_radius(wheel), wheel.model().width) - coupled_.radius() + gap;
}

void DemContact::write_checkpoint(const std::string& path) const {
  const CouplingState state = coupled_.state();
  dem::Archive archive;
  dem::store(soil_.state(), archive);
  archive.set_text("system", soil_.fingerprint());
  archive.set("wheel", state.wheel);
  archive.set("coupling_step", std::vector<std::int64_t>{state.step});
  std::vector<double> loads;
  for (const wheel::Wrench& load : state.soil_loads) {
    put(loads, load.force);
    put(loads, load.torque);
  }
  archive.set("soil_loads", loads, 6);
  std::vector<double> answers;
  for (const rig::HubLoad& answer : state.answers) {
    put(answers, answer.force_hub_rig);
    put(answers, answer.torque_hub_rig);
    answers.insert(answers.end(), {answer.drive_torque, answer.vertical_stiffness});
  }
  archive.set("answers", answers, answer_numbers);
  archive.set("motion", numbers_of(state.motion));
  archive.set("rim_travel", std::vector<double>{state.rim_travel});
  dem::write_archive(path, kind, archive);
}

void DemContact::resume(const std::string& path) {
  const dem::Archive archive = dem::read_archive(path, kind);
  if (archive.text("system") != soil_.fingerprint())
    throw Error(fmt::format("{}: the checkpoint belongs to another soil or bed", path));
  CouplingState state;
  state.wheel = archive.get<double>("wheel");
  state.step = archive.get<std::int64_t>("coupling_step").at(0);
  state.rim_travel = archive.get<double>("rim_travel").at(0);
  const auto& loads = archive.get<double>("soil_loads");
  const auto& answers = archive.get<double>("answers");
  const auto& motion = archive.get<double>("motion");
  if (loads.size() != 6 * coupled_.segments().size() || answers.size() % answer_numbers != 0 ||
      motion.size() != motion_numbers)
    throw Error(fmt::format("{}: the checkpoint belongs to another wheel", path));
  for (const double* in = loads.data(); in != loads.data() + loads.size();) {
    const Eigen::Vector3d force = take(in);
    state.soil_loads.push_back({force, take(in)});
  }
  for (const double* in = answers.data(); in != answers.data() + answers.size();) {
    rig::HubLoad answer;
    answer.force_hub_rig = take(in);
    answer.torque_hub_rig = take(in);
    answer.drive_torque = *in++;
    answer.vertical_stiffness = *in++;
    state.answers.push_back(answer);
  }
  state.motion = motion_of(motion);
  soil_.restore(dem::load_state(archive));
  coupled_.resume(std::move(state));
}

}  // namespace wheel_twin::cosim
