// How the F/T sensor of a rig is fixed, told by its own logs: the pitch torque is
//   M_y = -arm_z F_x + arm_x F_z + share T
// (doc/physics.md, "Rig and sensors") with T the motor's torque at the wheel shaft. Linear least squares over
// averages of a second, with a weak prior where the runs leave a direction open. No soil model is involved.
// SI units.
#pragma once

#include <vector>

#include "rig/settings.h"
#include "run_log/run_log.h"

namespace wheel_twin::rig {

struct MountFit {
  MountSettings mount;       ///< arm_x, arm_z and drive_torque_share as fitted, the rest as given
  double arm_x_error = 0.0;  ///< standard errors, m
  double arm_z_error = 0.0;
  double share_error = 0.0;
  double residual = 0.0;     ///< root mean square of the averages, N m
  std::size_t averages = 0;  ///< how many were used; 0: nothing was, `mount` is as given
};

/// `prior` is what is known beforehand, within 0.3 m and a share of 1. Logs without wrench or motor effort
/// are passed over. For runs with steering angle 0.
MountFit fit_mount(const std::vector<const run_log::RunLog*>& logs, const MountSettings& prior);

}  // namespace wheel_twin::rig
