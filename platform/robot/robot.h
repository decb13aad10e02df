// SPDX-License-Identifier: MIT
#pragma once

#include "platform/core/frames.h"
#include "platform/core/time.h"

namespace pipewright {

/// The arm that this build's planners and controller are sized for: the UF7. Kinematics are
/// templates on the joint count; everything after them uses these.
inline constexpr int kArmJoints = 7;
inline constexpr int kDof = 3 + kArmJoints;       ///< q = [x, y, phi, q1 ... q7], m and rad
inline constexpr int kControls = 2 + kArmJoints;  ///< u = [v, omega, q1' ... q7'], m/s and rad/s

using ArmVector = Vec<kArmJoints>;
using Configuration = Vec<kDof>;

/// The control after elimination of the nonholonomic row [sin phi, -cos phi, 0, 0] q' = 0:
///   q' = N(phi) u,  N = [cos phi 0; sin phi 0; 0 1] (+) I.  The lateral speed is zero by form.
using Controls = Vec<kControls>;

/// What the robot knows of itself in one control cycle. q's base part comes from localisation.
struct RobotState {
  Time stamp{};  ///< when the oldest of the joint readings below was taken
  Configuration q = Configuration::Zero();
  Controls u = Controls::Zero();  ///< measured velocities
  bool valid = false;             ///< every device is enabled, fresh and without fault
  bool emergency_stop = false;
};

}  // namespace pipewright
