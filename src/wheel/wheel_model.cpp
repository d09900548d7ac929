#include "wheel/wheel_model.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "wheel/calibration.h"

namespace wheel_twin::wheel {
namespace {

constexpr int kLeastSegments = 24;
constexpr int kMostSegments = 256;

Bending read_bending(const yaml::Map& map) {
  const std::string name = map.text("bending");
  if (name == "beam") return Bending::beam;
  if (name == "plate") return Bending::plate;
  if (name == "printed") return Bending::printed;
  map.fail("bending", fmt::format("beam, plate or printed is expected, not '{}'", name));
}

Suspension read_suspension(const yaml::Map& map) {
  const std::string name = map.text("suspension");
  if (name == "rigid") return Suspension::rigid;
  if (name == "springs") return Suspension::springs;
  if (name == "beams") return Suspension::beams;
  map.fail("suspension", fmt::format("rigid, springs or beams is expected, not '{}'", name));
}

Sheet read_sheet(const yaml::Map& map, double width) {
  Sheet sheet;
  sheet.thickness = map.number("thickness", {1.0e-5, 0.05});
  sheet.width = width;
  sheet.density = map.number("density", {100.0, 30000.0});
  sheet.young_modulus = map.number("young_modulus", {1.0e6, 1.0e12});
  sheet.poisson_ratio = map.number("poisson_ratio", {0.0, 0.499});
  return sheet;
}

void read_rim(const yaml::Map& rim, WheelModel& model) {
  model.rim = read_sheet(rim, model.width);
  model.bending = read_bending(rim);
  const auto given = rim.optional_number("joint_stiffness", yaml::positive());
  if (given) {
    model.rim_joint_stiffness = *given;
  } else if (model.bending == Bending::printed) {
    const double rigidity = model.rim.flexural_rigidity();
    model.rim_joint_stiffness =
        printed_stiffness(model.segments, model.radius, rigidity, small_load(model.radius, rigidity));
  } else {
    model.rim_joint_stiffness =
        bending_stiffness(model.rim, model.bending, 2.0 * M_PI * model.radius / model.segments);
  }
  rim.finish();
}

void read_springs(const yaml::Map& map, Springs& springs) {
  springs.positions = static_cast<int>(map.integer("positions", 1, kMostSegments));
  springs.sets = static_cast<int>(map.integer("sets", 1, 8));
  springs.radial_stiffness = map.number("radial_stiffness", yaml::positive());
  springs.tangential_stiffness = map.number("tangential_stiffness", yaml::non_negative());
  springs.tangential_depth = map.number("tangential_depth", {0.0, 5.0});
  springs.turning_stiffness = map.number("turning_stiffness", yaml::non_negative());
  map.finish();
}

void read_beams(const yaml::Map& map, const WheelModel& model, Beams& beams) {
  beams.positions = static_cast<int>(map.integer("positions", 1, kMostSegments));
  beams.sets = static_cast<int>(map.integer("sets", 1, 8));
  beams.bodies = static_cast<int>(map.integer("bodies", 2, 64));
  beams.sheet = read_sheet(map, map.number("width", {1.0e-4, 5.0}));
  const Bending bending = read_bending(map);
  const auto given = map.optional_number("joint_stiffness", yaml::positive());
  const double radius = 0.5 * (model.radius - model.hub_radius);
  if (given) {
    beams.joint_stiffness = *given;
  } else if (bending == Bending::printed) {
    const double rigidity = beams.sheet.flexural_rigidity();
    beams.joint_stiffness =
        printed_stiffness(2 * beams.bodies, radius, rigidity, small_load(radius, rigidity));
  } else {
    beams.joint_stiffness = bending_stiffness(beams.sheet, bending, M_PI * radius / beams.bodies);
  }
  map.finish();
}

void read_multibody(const yaml::Map& map, WheelModel& model) {
  model.suspension = read_suspension(map);
  model.segments = static_cast<int>(map.integer_or("segments", 64));
  check(model);
  model.grouser_thickness = map.number_or("grouser_thickness", model.grouser_thickness, {1.0e-5, 0.1});
  if (model.suspension == Suspension::rigid) {
    model.rim.thickness = map.number_or("thickness", 0.001, {1.0e-5, 0.05});
    map.finish();
    return;
  }
  const yaml::Map hub = map.map("hub");
  model.hub_radius = hub.number("radius", {1.0e-4, 5.0});
  model.hub_mass = hub.number("mass", yaml::positive());
  model.hub_inertia = hub.number("inertia", yaml::positive());
  hub.finish();
  read_rim(map.map("rim"), model);
  if (model.suspension == Suspension::springs) read_springs(map.map("springs"), model.springs);
  if (model.suspension == Suspension::beams) read_beams(map.map("beams"), model, model.beams);
  const yaml::Map damping = map.map("damping");
  model.damping_ratio = damping.number("ratio", {0.0, 2.0});
  model.damping_frequency = damping.number("frequency", yaml::positive());
  damping.finish();
  model.max_substeps = static_cast<int>(map.integer_or("max_substeps", model.max_substeps, 1, 1000));
  if (map.has("faults")) {
    const yaml::List faults = map.list("faults");
    for (std::size_t i = 0; i < faults.size(); ++i) {
      const yaml::Map entry = faults.map(i);
      Fault fault;
      fault.position = static_cast<int>(entry.integer("position", 0));
      fault.set = static_cast<int>(entry.integer("set", 0));
      fault.factor = entry.number("factor", {0.0, 100.0});
      entry.finish();
      model.faults.push_back(fault);
    }
  }
  map.finish();
}

}  // namespace

double Sheet::flexural_rigidity() const {
  return young_modulus * width * thickness * thickness * thickness / 12.0;
}

double segment_length(const WheelModel& model) {
  return 2.0 * model.radius * std::sin(M_PI / model.segments);
}

void check(const WheelModel& model) {
  const auto refuse = [&](const std::string& what) {
    throw Error(fmt::format("wheel '{}': {}", model.name, what));
  };
  if (model.segments % 2 != 0 || model.segments < kLeastSegments || model.segments > kMostSegments) {
    refuse(fmt::format("{} segments: an even number from {} to {} is needed", model.segments, kLeastSegments,
                       kMostSegments));
  }
  const auto positive = [&](double value, const char* name) {
    if (!(value > 0.0) || !std::isfinite(value))
      refuse(fmt::format("{} is {}: above 0 is needed", name, value));
  };
  const auto not_negative = [&](double value, const char* name) {
    if (!(value >= 0.0) || !std::isfinite(value))
      refuse(fmt::format("{} is {}: at least 0 is needed", name, value));
  };
  positive(model.radius, "radius");
  positive(model.width, "width");
  positive(model.rim.thickness, "rim thickness");
  not_negative(model.grouser_height, "grouser height");
  if (model.max_substeps < 1) refuse(fmt::format("{} sub-steps: at least 1 is needed", model.max_substeps));
  if (model.suspension == Suspension::rigid) return;
  positive(model.rim.density, "density");
  positive(model.hub_mass, "hub mass");
  positive(model.hub_inertia, "hub inertia");
  not_negative(model.rim_joint_stiffness, "rim joint stiffness");
  not_negative(model.springs.radial_stiffness, "radial stiffness");
  not_negative(model.springs.tangential_stiffness, "tangential stiffness");
  not_negative(model.springs.turning_stiffness, "turning stiffness");
  not_negative(model.beams.joint_stiffness, "beam joint stiffness");
  not_negative(model.damping_ratio, "damping ratio");
  if (model.damping_ratio > 0.0) positive(model.damping_frequency, "damping frequency");
  if (!(model.hub_radius > 0.0) || !(model.hub_radius < model.radius)) {
    refuse(fmt::format("hub radius is {}: between 0 and the wheel's radius {} is needed", model.hub_radius,
                       model.radius));
  }
  const bool beams = model.suspension == Suspension::beams;
  if (beams) positive(model.beams.sheet.thickness, "beam thickness");
  if (beams && model.beams.bodies < 2)
    refuse(fmt::format("{} bodies a beam: at least 2 are needed", model.beams.bodies));
  const int positions = beams ? model.beams.positions : model.springs.positions;
  const int sets = beams ? model.beams.sets : model.springs.sets;
  for (const Fault& fault : model.faults) {
    if (fault.position < 0 || fault.position >= positions || fault.set < 0 || fault.set >= sets) {
      refuse(fmt::format("fault at position {}, set {}: positions end at {}, sets at {}", fault.position,
                         fault.set, positions - 1, sets - 1));
    }
    not_negative(fault.factor, "fault factor");
  }
}

WheelModel read_wheel_model(const yaml::Map& map) {
  WheelModel model;
  model.name = map.text_or("name", model.name);
  model.radius = map.number("radius", {0.005, 5.0});
  model.width = map.number("width", {0.001, 5.0});
  model.grousers = static_cast<int>(map.integer_or("grousers", 0, 0, 10000));
  model.grouser_height = map.number_or("grouser_height", 0.0, {0.0, 1.0});
  map.skip("stiffness");
  model.rim.width = model.width;
  if (const auto multibody = map.optional_map("multibody")) {
    read_multibody(*multibody, model);
  } else {
    model.rim.thickness = 0.001;
  }
  map.finish();
  check(model);
  return model;
}

WheelModel read_wheel_file(const std::string& path) {
  return read_wheel_model(yaml::parse_file(path));
}

}  // namespace wheel_twin::wheel
