// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/fixed_vector.h"
#include "platform/robot/robot.h"

namespace pipewright {

/// What the controller is to reach: the set point x_d = [p_WS; z_WS] of law (3), and, when the
/// planner found one, a way there.
struct Goal {
  static constexpr int kMaxWaypoints = 64;

  std::uint32_t id = 0;  ///< 0: no goal, stand still. A new goal has a new id.
  Vector3d p_WS = Vector3d::Zero();
  Vector3d z_WS = Vector3d::UnitZ();

  /// Configurations from near the robot's own to one whose sensor is at (p_WS, z_WS). Between two
  /// of them the base turns on the spot, drives straight and turns again (any of the three may be
  /// nothing), while the joints move in proportion to the way done. Empty: go to x_d directly.
  FixedVector<Configuration, kMaxWaypoints> path;
};

/// What the controller says of the goal it holds.
enum class GoalState : std::uint8_t {
  kNone,  ///< no goal
  kMoving,
  kReached,  ///< error within tolerance
  kStalled,  ///< the error has not changed for the stall time
};

struct GoalProgress {
  std::uint32_t id = 0;
  GoalState state = GoalState::kNone;
  double error = 0;  ///< ||[p_WS - p_d; z_WS - z_d]||, m and 1
};

}  // namespace pipewright
