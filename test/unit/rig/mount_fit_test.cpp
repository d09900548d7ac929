#include "rig/mount_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rig/free_run.h"
#include "test_contact.h"

namespace wheel_twin::rig {
namespace {

run_log::RunLog log_of(double slip, const MountSettings& mount, double resistance) {
  TestContact contact;
  contact.resistance = resistance;  // makes drawbar pull and drive torque independent
  RunSettings settings;
  settings.rig = plain_rig();
  settings.rig.slide.viscous_damping = 60.0;
  settings.rig.mount = mount;
  settings.conditions.slip = slip;
  settings.profile.travel = 0.1;
  settings.sensors.ft.noise << 0.02, 0.02, 0.05, 4e-4, 4e-4, 2e-4;
  settings.sensors.joints.effort_noise = 0.015;
  FreeRun run(settings, contact, {});
  RunSummary summary;
  return run_to_end(run, summary);
}

TEST(MountFit, FindsArmAndShareFromTheLogs) {
  for (const double share : {-1.0, 0.0, 1.0}) {
    MountSettings mount;
    mount.arm_x = 0.03;
    mount.arm_z = 0.21;
    mount.drive_torque_share = share;
    const run_log::RunLog a = log_of(0.0, mount, 2.0);
    const run_log::RunLog b = log_of(0.3, mount, 1.0);
    const run_log::RunLog c = log_of(0.6, mount, 0.5);
    const MountFit fit = fit_mount({&a, &b, &c}, MountSettings());
    // Four standard errors, and what noise in the regressors (0.015 N m over 100 samples) adds.
    EXPECT_NEAR(fit.mount.arm_x, 0.03, 4.0 * fit.arm_x_error + 1e-4);
    EXPECT_NEAR(fit.mount.arm_z, 0.21, 4.0 * fit.arm_z_error + 1e-3);
    EXPECT_NEAR(fit.mount.drive_torque_share, share, 4.0 * fit.share_error + 1e-2);
    EXPECT_LT(fit.share_error, 0.05);
    EXPECT_LT(fit.residual, 0.01);
    EXPECT_GT(fit.averages, 15u);
  }
}

TEST(MountFit, KeepsToThePriorWhereTheLogsSayNothing) {
  MountSettings prior;
  prior.arm_z = 0.2;
  EXPECT_EQ(fit_mount({}, prior).averages, 0u);
  EXPECT_EQ(fit_mount({}, prior).mount.arm_z, 0.2);
  run_log::RunLog still;  // the wheel stands: no thrust, no torque
  for (int i = 0; i < 100; ++i) {
    still.ft.time.push_back(0.1 * i);
    still.ft.force.emplace_back(0.0, 0.0, 42.1);
    still.ft.torque.emplace_back(0.0, 0.421, 0.0);
    still.joints.time.push_back(0.1 * i);
    still.joints.wheel_effort.push_back(0.0);
  }
  const MountFit fit = fit_mount({&still}, prior);
  EXPECT_NEAR(fit.mount.arm_x, 0.01, 1e-6);
  EXPECT_NEAR(fit.mount.arm_z, 0.2, 1e-9);
  EXPECT_NEAR(fit.mount.drive_torque_share, -1.0, 1e-9);
}

}  // namespace
}  // namespace wheel_twin::rig
