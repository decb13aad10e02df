// SPDX-License-Identifier: MIT
#pragma once

#include <numbers>

#include "platform/robot/model.h"

namespace pipewright {

/// UFACTORY xArm 7. Kinematics and position limits as the vendor publishes them (developer article
/// "xArm 7 kinematic parameters"; SDK limits of type XARM7_X4). The joints can do pi rad/s.
inline constexpr ArmModel<7> kUf7 = [] {
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr double kSpeedMax = std::numbers::pi;
  // clang-format off
  return ArmModel<7>{{{
      //  a      quarter     d       min         max      speed max  used  accel.
      {0,         0,      0.267,   -kTurn,     kTurn,     kSpeedMax, 1.0, 10.0},
      {0,        -1,      0,       -2.059488,  2.094395,  kSpeedMax, 1.0, 10.0},
      {0,         1,      0.293,   -kTurn,     kTurn,     kSpeedMax, 1.0, 10.0},
      {0.0525,    1,      0,       -0.191986,  3.92699,   kSpeedMax, 1.0, 10.0},
      {0.0775,    1,      0.3425,  -kTurn,     kTurn,     kSpeedMax, 1.0, 10.0},
      {0,         1,      0,       -1.692969,  std::numbers::pi, kSpeedMax, 1.0, 10.0},
      {0.076,    -1,      0.097,   -kTurn,     kTurn,     kSpeedMax, 1.0, 10.0},
  }}};
  // clang-format on
}();

/// The robot of this product: UF7 on a Tracer, camera and probe at the flange.
inline constexpr RobotModel<7> kTracerUf7{
    .arm = kUf7, .base = {}, .mount = {}, .tool = {}, .home_rad = {0, -0.9, 0, 0.5, 0, -0.4, 0}};
static_assert(Valid(kTracerUf7));

constexpr const RobotModel<7>& TracerUf7() { return kTracerUf7; }

}  // namespace pipewright
