// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "platform/core/frames.h"

namespace pipewright {

/// One revolute joint: its row of modified (Craig) DH parameters and its limits.
///
///   X_{i-1,i} = Rx(alpha) Tx(a) Rz(q) Tz(d)
///
/// alpha is a whole number of quarter turns on both arms, which makes its sine and cosine exact.
struct ArmJoint {
  double a_m = 0;
  int alpha_quarter_turns = 0;
  double d_m = 0;
  double q_min_rad = 0;
  double q_max_rad = 0;
  double speed_max_radps = 0;  ///< the device's own limit
  double speed_radps = 0;      ///< what this robot uses
  double acceleration_max_radps2 = 0;
};

template <int kJoints>
struct ArmModel {
  std::array<ArmJoint, kJoints> joints;
};

/// A differential drive. B is on the floor, midway between the wheels and below the body's centre.
struct TracerModel {
  double length_m = 0.700;
  double width_m = 0.500;
  double height_m = 0.163;
  double clearance_m = 0.036;
  double track_m = 0.350;          ///< sources differ by model year (0.335 to 0.517)
  double wheel_radius_m = 0.0605;  ///< likewise (0.0605 to 0.0824)
  double speed_mps = 0.4;          ///< operating limits; the vehicle could do 1.8 m/s
  double turn_radps = 1.0;
  double acceleration_mps2 = 0.8;
  double turn_acceleration_radps2 = 2.0;
};

/// X_BA: where the arm's foot stands in the base.
struct MountConfig {
  std::array<double, 3> p_BA_m = {0.10, 0, 0.28};
  double yaw_rad = 0;
};

/// What the flange carries. S and P have the axes of F; z_S looks along z_F, x_S along x_F.
struct ToolConfig {
  std::array<double, 3> p_FS_m = {0, 0, 0.045};
  std::array<double, 3> p_FP_m = {0, 0.045, 0.050};
};

/// A mobile manipulator with kJoints revolute joints: everything its kinematics needs.
template <int kJoints>
struct RobotModel {
  ArmModel<kJoints> arm;
  TracerModel base;
  MountConfig mount;
  ToolConfig tool;
  std::array<double, kJoints> home_rad{};  ///< a posture for driving, free of self-collision
};

template <int kJoints>
constexpr bool Valid(const RobotModel<kJoints>& robot) {
  for (int i = 0; i < kJoints; ++i) {
    const ArmJoint& joint = robot.arm.joints[i];
    const bool valid = joint.q_min_rad < joint.q_max_rad && 0 < joint.speed_radps &&
                       joint.speed_radps <= joint.speed_max_radps &&
                       0 < joint.acceleration_max_radps2 && joint.q_min_rad < robot.home_rad[i] &&
                       robot.home_rad[i] < joint.q_max_rad;
    if (!valid) {
      return false;
    }
  }
  const TracerModel& base = robot.base;
  return 0 < base.speed_mps && 0 < base.turn_radps && 0 < base.acceleration_mps2 &&
         0 < base.turn_acceleration_radps2 && 0 < base.track_m && 0 < base.wheel_radius_m &&
         0 <= base.clearance_m && base.clearance_m < base.height_m && 0 < base.length_m &&
         0 < base.width_m;
}

/// One limit of all joints as a vector, as in JointValues(robot, &ArmJoint::q_min_rad).
template <int kJoints>
Vec<kJoints> JointValues(const RobotModel<kJoints>& robot, double ArmJoint::*limit) {
  Vec<kJoints> values;
  for (int i = 0; i < kJoints; ++i) {
    values(i) = robot.arm.joints[i].*limit;
  }
  return values;
}

template <int kJoints>
Vec<kJoints> HomeJoints(const RobotModel<kJoints>& robot) {
  return Eigen::Map<const Vec<kJoints>>(robot.home_rad.data());
}

}  // namespace pipewright
