// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <vector>

#include "ctrl/robot_program/control_task.h"

namespace pipewright::test {

/// What no field of a configuration can be.
inline constexpr double kUnusable[] = {
    std::numeric_limits<double>::quiet_NaN(),   std::numeric_limits<double>::infinity(),
    -std::numeric_limits<double>::infinity(),   std::numeric_limits<double>::denorm_min(),
    -std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max(),
    -std::numeric_limits<double>::max(),        1e300};

struct Field {
  const char* name;
  double* (*of)(ControlTaskConfig& config);
};
struct DurationField {
  const char* name;
  Duration* (*of)(ControlTaskConfig& config);
};

/// Every number of the control task's configuration. Written out: a field that is added without its
/// line here, and its check in Valid(), is one that nobody looks at.
inline std::vector<Field> Fields() {
  using C = ControlTaskConfig;
  return {
      {"law.constraints.period_s", [](C& c) { return &c.law.constraints.period_s; }},
      {"law.constraints.eta_1ps", [](C& c) { return &c.law.constraints.eta_1ps; }},
      {"law.constraints.eta_voxel_1ps", [](C& c) { return &c.law.constraints.eta_voxel_1ps; }},
      {"law.constraints.eta_self_1ps", [](C& c) { return &c.law.constraints.eta_self_1ps; }},
      {"law.constraints.eta_joint_1ps", [](C& c) { return &c.law.constraints.eta_joint_1ps; }},
      {"law.constraints.d_safe_plane_m", [](C& c) { return &c.law.constraints.d_safe_plane_m; }},
      {"law.constraints.d_safe_base_plane_m",
       [](C& c) { return &c.law.constraints.d_safe_base_plane_m; }},
      {"law.constraints.d_safe_pipe_m", [](C& c) { return &c.law.constraints.d_safe_pipe_m; }},
      {"law.constraints.margin_m", [](C& c) { return &c.law.constraints.margin_m; }},
      {"law.constraints.voxel_margin_m", [](C& c) { return &c.law.constraints.voxel_margin_m; }},
      {"law.constraints.voxel_noise_m", [](C& c) { return &c.law.constraints.voxel_noise_m; }},
      {"law.constraints.self_margin_m", [](C& c) { return &c.law.constraints.self_margin_m; }},
      {"law.constraints.plane_inflation_m",
       [](C& c) { return &c.law.constraints.plane_inflation_m; }},
      {"law.constraints.plane_behind_m", [](C& c) { return &c.law.constraints.plane_behind_m; }},
      {"law.constraints.near_vertical_nz",
       [](C& c) { return &c.law.constraints.near_vertical_nz; }},
      {"law.constraints.pipe_inflation_m",
       [](C& c) { return &c.law.constraints.pipe_inflation_m; }},
      {"law.constraints.consider_m", [](C& c) { return &c.law.constraints.consider_m; }},
      {"law.constraints.consider_self_m", [](C& c) { return &c.law.constraints.consider_self_m; }},
      {"law.constraints.ahead_s", [](C& c) { return &c.law.constraints.ahead_s; }},
      {"law.constraints.recovery_mps", [](C& c) { return &c.law.constraints.recovery_mps; }},
      {"law.constraints.alpha", [](C& c) { return &c.law.constraints.alpha; }},
      {"law.constraints.price[0]", [](C& c) { return &c.law.constraints.price[0]; }},
      {"law.constraints.price[1]", [](C& c) { return &c.law.constraints.price[1]; }},
      {"law.constraints.price[2]", [](C& c) { return &c.law.constraints.price[2]; }},
      {"law.constraints.price[3]", [](C& c) { return &c.law.constraints.price[3]; }},
      {"law.constraints.price[4]", [](C& c) { return &c.law.constraints.price[4]; }},
      {"law.constraints.price[5]", [](C& c) { return &c.law.constraints.price[5]; }},
      {"law.constraints.price[6]", [](C& c) { return &c.law.constraints.price[6]; }},
      {"law.constraints.price[7]", [](C& c) { return &c.law.constraints.price[7]; }},
      {"law.follower.speed_fraction", [](C& c) { return &c.law.follower.speed_fraction; }},
      {"law.follower.acceleration_fraction",
       [](C& c) { return &c.law.follower.acceleration_fraction; }},
      {"law.follower.lag_free", [](C& c) { return &c.law.follower.lag_free; }},
      {"law.follower.lag_stop", [](C& c) { return &c.law.follower.lag_stop; }},
      {"law.follower.k_along_1ps", [](C& c) { return &c.law.follower.k_along_1ps; }},
      {"law.follower.k_across_1pm2", [](C& c) { return &c.law.follower.k_across_1pm2; }},
      {"law.follower.k_heading_1ps", [](C& c) { return &c.law.follower.k_heading_1ps; }},
      {"law.follower.k_joint_1ps", [](C& c) { return &c.law.follower.k_joint_1ps; }},
      {"law.kappa_1ps", [](C& c) { return &c.law.kappa_1ps; }},
      {"law.lambda_c", [](C& c) { return &c.law.lambda_c; }},
      {"law.reached", [](C& c) { return &c.law.reached; }},
      {"law.stall_s", [](C& c) { return &c.law.stall_s; }},
      {"law.stall_change", [](C& c) { return &c.law.stall_change; }},
      {"law.smoothing_s", [](C& c) { return &c.law.smoothing_s; }},
      {"law.give_up_s", [](C& c) { return &c.law.give_up_s; }},
      {"law.settle", [](C& c) { return &c.law.settle; }},
      {"law.settle_s", [](C& c) { return &c.law.settle_s; }},
      {"law.settle_1ps", [](C& c) { return &c.law.settle_1ps; }},
      {"law.settle_damping", [](C& c) { return &c.law.settle_damping; }},
      {"localization.odometry.track_m", [](C& c) { return &c.localization.odometry.track_m; }},
      {"localization.odometry.quantum_m", [](C& c) { return &c.localization.odometry.quantum_m; }},
      {"localization.odometry.max_wheel_mps",
       [](C& c) { return &c.localization.odometry.max_wheel_mps; }},
      {"localization.odometry.slip.m", [](C& c) { return &c.localization.odometry.slip.m; }},
      {"localization.odometry.slip.rad_per_m",
       [](C& c) { return &c.localization.odometry.slip.rad_per_m; }},
      {"localization.odometry.slip.rad_per_rad",
       [](C& c) { return &c.localization.odometry.slip.rad_per_rad; }},
      {"localization.slip.m", [](C& c) { return &c.localization.slip.m; }},
      {"localization.slip.rad_per_m", [](C& c) { return &c.localization.slip.rad_per_m; }},
      {"localization.slip.rad_per_rad", [](C& c) { return &c.localization.slip.rad_per_rad; }},
      {"localization.slip_start", [](C& c) { return &c.localization.slip_start; }},
      {"localization.slip_least", [](C& c) { return &c.localization.slip_least; }},
      {"localization.slip_most", [](C& c) { return &c.localization.slip_most; }},
      {"localization.slip_learning", [](C& c) { return &c.localization.slip_learning; }},
      {"localization.yaw_scale_sigma", [](C& c) { return &c.localization.yaw_scale_sigma; }},
      {"localization.yaw_scale_walk", [](C& c) { return &c.localization.yaw_scale_walk; }},
      {"localization.yaw_scale_max", [](C& c) { return &c.localization.yaw_scale_max; }},
      {"localization.way_scale_sigma", [](C& c) { return &c.localization.way_scale_sigma; }},
      {"localization.way_scale_walk", [](C& c) { return &c.localization.way_scale_walk; }},
      {"localization.way_scale_max", [](C& c) { return &c.localization.way_scale_max; }},
      {"localization.slow_radps", [](C& c) { return &c.localization.slow_radps; }},
      {"localization.fast_radps", [](C& c) { return &c.localization.fast_radps; }},
      {"localization.fix.share", [](C& c) { return &c.localization.fix.share; }},
      {"localization.fix.sigma_m", [](C& c) { return &c.localization.fix.sigma_m; }},
      {"localization.fix.sigma_rad", [](C& c) { return &c.localization.fix.sigma_rad; }},
      {"localization.fix.tilt_rad", [](C& c) { return &c.localization.fix.tilt_rad; }},
      {"localization.fix.gate", [](C& c) { return &c.localization.fix.gate; }},
      {"localization.lost_m", [](C& c) { return &c.localization.lost_m; }},
      {"localization.lost_rad", [](C& c) { return &c.localization.lost_rad; }},
      {"base.standstill_mps", [](C& c) { return &c.base.standstill_mps; }},
      {"base.standstill_radps", [](C& c) { return &c.base.standstill_radps; }},
      {"arm.standstill_radps", [](C& c) { return &c.arm.standstill_radps; }},
      {"joint_sigma_rad", [](C& c) { return &c.joint_sigma_rad; }},
      {"start.x_m", [](C& c) { return &c.start.x_m; }},
      {"start.y_m", [](C& c) { return &c.start.y_m; }},
      {"start.phi_rad", [](C& c) { return &c.start.phi_rad; }},
      {"start.covariance(0, 0)", [](C& c) { return &c.start.covariance(0, 0); }},
      {"start.covariance(0, 1)", [](C& c) { return &c.start.covariance(0, 1); }},
      {"start.covariance(0, 2)", [](C& c) { return &c.start.covariance(0, 2); }},
      {"start.covariance(1, 0)", [](C& c) { return &c.start.covariance(1, 0); }},
      {"start.covariance(1, 1)", [](C& c) { return &c.start.covariance(1, 1); }},
      {"start.covariance(1, 2)", [](C& c) { return &c.start.covariance(1, 2); }},
      {"start.covariance(2, 0)", [](C& c) { return &c.start.covariance(2, 0); }},
      {"start.covariance(2, 1)", [](C& c) { return &c.start.covariance(2, 1); }},
      {"start.covariance(2, 2)", [](C& c) { return &c.start.covariance(2, 2); }},
  };
}

inline std::vector<DurationField> DurationFields() {
  using C = ControlTaskConfig;
  return {
      {"base.start_timeout", [](C& c) { return &c.base.start_timeout; }},
      {"base.enable_timeout", [](C& c) { return &c.base.enable_timeout; }},
      {"base.request_period", [](C& c) { return &c.base.request_period; }},
      {"base.command_period", [](C& c) { return &c.base.command_period; }},
      {"base.state_timeout", [](C& c) { return &c.base.state_timeout; }},
      {"base.stop_timeout", [](C& c) { return &c.base.stop_timeout; }},
      {"arm.start_timeout", [](C& c) { return &c.arm.start_timeout; }},
      {"arm.sdo_timeout", [](C& c) { return &c.arm.sdo_timeout; }},
      {"arm.enable_timeout", [](C& c) { return &c.arm.enable_timeout; }},
      {"arm.feedback_timeout", [](C& c) { return &c.arm.feedback_timeout; }},
      {"arm.heartbeat_timeout", [](C& c) { return &c.arm.heartbeat_timeout; }},
      {"arm.rest_timeout", [](C& c) { return &c.arm.rest_timeout; }},
      {"arm.disable_timeout", [](C& c) { return &c.arm.disable_timeout; }},
      {"localization.odometry.max_gap", [](C& c) { return &c.localization.odometry.max_gap; }},
      {"state_timeout", [](C& c) { return &c.state_timeout; }},
  };
}

}  // namespace pipewright::test
