// SPDX-License-Identifier: MIT
#pragma once

#include <numbers>

#include "platform/robot/model.h"

namespace pipewright {

/// Universal Robots UR5e: the vendor's published DH table (article "DH parameters for calculations
/// of kinematics and dynamics"), moved one row from standard to modified DH. Its last row has
/// alpha = a = 0, so the flange frame is the same in both. The joints can do pi rad/s.
inline constexpr ArmModel<6> kUr5e = [] {
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr double kHalfTurn = std::numbers::pi;  // the elbow's range
  constexpr double kSpeedMax = std::numbers::pi;
  // clang-format off
  return ArmModel<6>{{{
      //  a     quarter     d        min         max       speed max  used  accel.
      {0,         0,      0.1625,  -kTurn,      kTurn,      kSpeedMax, 1.0, 10.0},
      {0,         1,      0,       -kTurn,      kTurn,      kSpeedMax, 1.0, 10.0},
      {-0.425,    0,      0,       -kHalfTurn,  kHalfTurn,  kSpeedMax, 1.0, 10.0},
      {-0.3922,   0,      0.1333,  -kTurn,      kTurn,      kSpeedMax, 1.0, 10.0},
      {0,         1,      0.0997,  -kTurn,      kTurn,      kSpeedMax, 1.0, 10.0},
      {0,        -1,      0.0996,  -kTurn,      kTurn,      kSpeedMax, 1.0, 10.0},
  }}};
  // clang-format on
}();

inline constexpr RobotModel<6> kTracerUr5e{
    .arm = kUr5e, .base = {}, .mount = {}, .tool = {}, .home_rad = {0, -1.9, 2.2, -0.3, -1.57, 0}};
static_assert(Valid(kTracerUr5e));

constexpr const RobotModel<6>& TracerUr5e() { return kTracerUr5e; }

}  // namespace pipewright
