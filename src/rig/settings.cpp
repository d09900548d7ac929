#include "rig/settings.h"

namespace wheel_twin::rig {
namespace {

CarriageSettings read_carriage(const yaml::Map& map) {
  CarriageSettings carriage;
  carriage.speed_lag = map.number("speed_lag", {0.0, 10.0});
  carriage.belt_stiffness = map.optional_number("belt_stiffness", {1.0, 1e12});
  carriage.belt_lag = map.number_or("belt_lag", carriage.belt_lag, {0.0, 10.0});
  carriage.stroke = map.number("stroke", yaml::positive());
  map.finish();
  return carriage;
}

SlideSettings read_slide(const yaml::Map& map) {
  SlideSettings slide;
  slide.viscous_damping = map.number("viscous_damping", yaml::non_negative());
  slide.coulomb_friction = map.number("coulomb_friction", yaml::non_negative());
  slide.mass = map.optional_number("mass", yaml::positive());
  slide.travel_below = map.number("travel_below", yaml::positive());
  map.finish();
  return slide;
}

DriveSettings read_drive(const yaml::Map& map) {
  DriveSettings drive;
  drive.speed_lag = map.number("speed_lag", {0.0, 10.0});
  drive.inertia = map.number("inertia", yaml::non_negative());
  drive.viscous_loss = map.number("viscous_loss", yaml::non_negative());
  drive.coulomb_loss = map.number("coulomb_loss", yaml::non_negative());
  drive.free_inertia = map.number("free_inertia", yaml::positive());
  drive.bearing_friction = map.number("bearing_friction", yaml::non_negative());
  map.finish();
  return drive;
}

MountSettings read_mount(const yaml::Map& map) {
  MountSettings mount;
  mount.arm_x = map.number("arm_x", {-10.0, 10.0});
  mount.arm_y = map.number("arm_y", {-10.0, 10.0});
  mount.arm_z = map.number("arm_z", {-10.0, 10.0});
  mount.tool_mass = map.number("tool_mass", yaml::non_negative());
  mount.drive_torque_share = map.number("drive_torque_share", {-1.0, 1.0});
  map.finish();
  return mount;
}

}  // namespace

RigSettings read_rig(const yaml::Map& map) {
  RigSettings rig;
  rig.name = map.text("name");
  rig.carriage = read_carriage(map.map("carriage"));
  rig.slide = read_slide(map.map("slide"));
  rig.drive = read_drive(map.map("drive"));
  rig.mount = read_mount(map.map("mount"));
  rig.steering_limit = map.number("steering_limit", {0.0, 1.5707963267948966});
  rig.gravity = map.number_or("gravity", rig.gravity, yaml::positive());
  map.finish();
  return rig;
}

}  // namespace wheel_twin::rig
