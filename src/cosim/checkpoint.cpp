#include "cosim/checkpoint.h"

#include <fmt/format.h>

#include <vector>

#include "base/error.h"
#include "cosim/wheel_faces.h"
#include "dem/state_file.h"

namespace wheel_twin::cosim {
namespace {

constexpr std::size_t motion_numbers = 10;
constexpr std::size_t answer_numbers = 8;

void put(std::vector<double>& out, const Eigen::Vector3d& v) {
  out.insert(out.end(), {v.x(), v.y(), v.z()});
}

Eigen::Vector3d take(const double*& in) {
  const Eigen::Vector3d v(in[0], in[1], in[2]);
  in += 3;
  return v;
}

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

dem::Archive soil_archive(const DemSoil& soil) {
  dem::Archive archive;
  dem::store(soil.state(), archive);
  archive.set_text("system", soil.fingerprint());
  return archive;
}

void restore_soil(const dem::Archive& archive, const std::string& path, DemSoil& soil) {
  if (archive.text("system") != soil.fingerprint())
    throw Error(fmt::format("{}: the checkpoint belongs to another soil or bed", path));
  soil.restore(dem::load_state(archive));
}

void store(const CouplingState& state, dem::Archive& archive) {
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
}

CouplingState load_coupling(const dem::Archive& archive, const std::string& path, std::size_t segments) {
  CouplingState state;
  state.wheel = archive.get<double>("wheel");
  state.step = archive.get<std::int64_t>("coupling_step").at(0);
  state.rim_travel = archive.get<double>("rim_travel").at(0);
  const auto& loads = archive.get<double>("soil_loads");
  const auto& answers = archive.get<double>("answers");
  const auto& motion = archive.get<double>("motion");
  if (loads.size() != 6 * segments || answers.size() % answer_numbers != 0 || motion.size() != motion_numbers)
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
  return state;
}

std::string wheel_fingerprint(const wheel::FlexibleWheel& wheel) {
  std::vector<double> numbers{wheel.model().radius};
  for (const wheel::SegmentShape& shape : segment_shapes(wheel)) {
    for (const wheel::Box& box : shape.boxes) {
      put(numbers, box.centre);
      put(numbers, box.half_extents);
    }
  }
  dem::Archive archive;
  archive.set("faces", std::move(numbers));
  return archive.hash();
}

}  // namespace wheel_twin::cosim
