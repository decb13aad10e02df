// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "ctrl/constraints/config.h"
#include "platform/core/usable.h"

namespace pipewright {

/// How a reference is moved along Goal::path.
struct FollowerConfig {
  double speed_fraction = 0.9;  ///< of the operating speed limits
  double acceleration_fraction = 0.8;
  double lag_free = 0.05;    ///< tracking error (m + rad, largest of them) that slows nothing
  double lag_stop = 0.25;    ///< and that stops the reference
  double k_along_1ps = 2;    ///< Kanayama's K_x
  double k_across_1pm2 = 6;  ///< K_y
  double k_heading_1ps = 2;  ///< on the heading error, also when turning on the spot
  double k_joint_1ps = 2;    ///< posture feedback
};

constexpr bool Valid(const FollowerConfig& c) {
  return Usable({c.speed_fraction, c.acceleration_fraction, c.lag_free, c.lag_stop, c.k_along_1ps,
                 c.k_across_1pm2, c.k_heading_1ps, c.k_joint_1ps}) &&
         c.speed_fraction > 0 && c.speed_fraction <= 1 && c.acceleration_fraction > 0 &&
         c.acceleration_fraction <= 1 && c.lag_free >= 0 && c.lag_stop > c.lag_free &&
         c.k_along_1ps >= 0 && c.k_across_1pm2 >= 0 && c.k_heading_1ps >= 0 && c.k_joint_1ps >= 0;
}

/// Law (3) and when it is done. Defaults are Table I of the CFNBV paper.
struct WholeBodyConfig {
  ConstraintConfig constraints;
  FollowerConfig follower;
  double kappa_1ps = 6;
  double lambda_c = 1.2;
  double reached = 0.001;      ///< ‖x − x_d‖ of a goal that is reached
  double stall_s = 4;          ///< without change for this long: stalled
  double stall_change = 3e-4;  ///< what counts as a change of ‖x − x_d‖ (or of the way done),
  double smoothing_s = 0.5;    ///< after a first-order low-pass, for readings are quantised
  double give_up_s = 12;  ///< without a smaller ‖x − x_d‖ or progress on the way: stalled too
  double settle = 0.05;   ///< at the path's end and this near, only the set point counts,
  double settle_s = 1;    ///< or so long after the reference arrived there
  double settle_1ps = 2;  ///< then u_n closes ‖x − x_d‖ at this rate, for λ_c resists
  double settle_damping = 1e-3;  ///< of its pseudo-inverse
  int svfi_rounds = 12;          ///< QPs solved at most in a cycle to meet the cones
  /// Nanoseconds of any clock that runs on, for figures alone: no decision hangs on it. May be
  /// null.
  std::int64_t (*stopwatch)() = nullptr;
};

constexpr bool Valid(const WholeBodyConfig& c) {
  return Valid(c.constraints) && Valid(c.follower) &&
         Usable({c.kappa_1ps, c.lambda_c, c.reached, c.stall_s, c.stall_change, c.smoothing_s,
                 c.give_up_s, c.settle, c.settle_s, c.settle_1ps, c.settle_damping}) &&
         c.kappa_1ps > 0 && c.lambda_c > 0 && c.kappa_1ps * c.constraints.period_s < 1 &&
         c.reached > 0 && c.stall_s > 0 && c.stall_change > 0 && c.give_up_s >= c.stall_s &&
         c.settle >= 0 && c.settle_s >= 0 && c.smoothing_s >= 0 && c.settle_1ps >= 0 &&
         c.settle_damping > 0 && c.svfi_rounds >= 1;
}
static_assert(Valid(WholeBodyConfig{}));

}  // namespace pipewright
