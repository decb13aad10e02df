// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "plan/motion/collision.h"
#include "platform/core/rng.h"
#include "platform/robot/robot.h"

namespace pipewright {

/// Where the sensor is to be: its position and its optical axis (|z_WS| = 1); the turn about the
/// axis is free.
struct SensorTarget {
  Vector3d p_WS = Vector3d::Zero();
  Vector3d z_WS = Vector3d::UnitX();
};

struct ReachConfig {
  bool hold_base = false;    ///< only the arm moves
  int iterations = 40;       ///< per attempt, at most
  int attempts = 6;          ///< the first from the seed, the others from random postures
  double position_m = 1e-4;  ///< reached when within both
  double axis = 1e-3;
  double base_weight = 0.5;  ///< how willingly the base moves, against a joint's 1
};

/// The nearest solution downhill of the seed, free or not: damped least squares on
/// [p_WS; z_WS] over q, joints kept within their limits. The base counts as holonomic here.
std::optional<Configuration> SolveSensor(const SensorTarget& target, const Configuration& seed,
                                         const ReachConfig& config = {});

/// The same posture with every joint at the whole turn that is nearest to the reference's, where
/// its limits allow: the arm need not unwind.
Configuration Unwound(const Configuration& q, const Configuration& reference);

/// A free configuration with the sensor at the target, unwound to the seed, or nothing. Every other
/// attempt, the first too, holds the base. Bounded: attempts x iterations.
std::optional<Configuration> Reach(const CollisionChecker& checker, const SensorTarget& target,
                                   const Configuration& seed, Rng& rng,
                                   const ReachConfig& config = {});

}  // namespace pipewright
