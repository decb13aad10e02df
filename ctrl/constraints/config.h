// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "ctrl/constraints/row.h"
#include "platform/core/usable.h"

namespace pipewright {

/// At which u the deviation σ_f(u) of a stochastic VFI is taken.
enum class SvfiMode : std::uint8_t {
  kExact,             ///< at the u that is sent: a second-order cone
  kPreviousVelocity,  ///< at the last cycle's u, as published: too small while accelerating
  kWorstCase,         ///< its upper bound over the box of u: never too small
};

inline constexpr SvfiMode kSvfiModes[] = {SvfiMode::kExact, SvfiMode::kPreviousVelocity,
                                          SvfiMode::kWorstCase};

constexpr const char* Name(SvfiMode mode) {
  switch (mode) {
    case SvfiMode::kExact:
      return "exact";
    case SvfiMode::kPreviousVelocity:
      return "previous_velocity";
    case SvfiMode::kWorstCase:
      return "worst_case";
  }
  return "?";
}

/// Distances, rates and softness of the constraint rows. Defaults are Table I of the CFNBV paper
/// where it has a value.
struct ConstraintConfig {
  double period_s = 0.01;  ///< u is held this long

  double eta_1ps = 1;        ///< η of (5), planes and pipes
  double eta_voxel_1ps = 2;  ///< the same for obstacle voxels and columns
  double eta_self_1ps = 2;
  double eta_joint_1ps = 4;

  /// d_safe of a sphere of radius r is the larger of the table's value and r + margin.
  double d_safe_plane_m = 0.1;
  double d_safe_base_plane_m = 0.5;
  double d_safe_pipe_m = 0.075;  ///< plus the pipe's radius: distances to pipes are to the axis
  double margin_m = 0.025;       // plans keep 0.03: room for tracking
  /// Beyond the map's noise, for what that is not: another voxel becomes the nearest within a
  /// period (some 6 mm), a query between two cells says more than the distance (9 mm seen).
  double voxel_margin_m = 0.017;
  /// Deviation of an obstacle voxel's place, each axis alone. Not its width: the distance is to its
  /// box, which holds the reading wherever that fell in it. But where the reading fell: the depth
  /// camera's σ at 1 m (3.8 mm), its pose's error (2 mm, and 2 mrad at 1 m), 4.7 mm in all. At α =
  /// 0.7 it asks for 2.6 mm standing still, 0.0196 m with the margin.
  double voxel_noise_m = 0.005;
  double self_margin_m = 0.02;

  /// Planes are slabs (PointToSlab): so much wider than the rectangle that was seen, and so deep.
  double plane_inflation_m = 0.2;
  double plane_behind_m = 0.15;
  double near_vertical_nz = 0.3;  ///< |n_z| below which a plane stops the base
  /// The seen part of a pipe's axis counts as this much longer at either end. On the axis that
  /// keeps inflation + radius + d_safe, some 0.2 m, beyond what was seen.
  double pipe_inflation_m = 0.05;
  /// Pairs with more than this to spare make no row. Voxels and columns: that may come nearer
  /// faster than eta_1ps times this.
  double consider_m = 0.5;
  double consider_self_m = 0.15;  ///< likewise pairs of the robot's own parts
  double ahead_s = 0.25;       ///< a second obstacle voxel is looked for where the point is heading
  double recovery_mps = 0.05;  ///< how fast at most a too near place is left

  SvfiMode svfi = SvfiMode::kExact;
  double alpha = 0.7;  ///< in [0.5, 1)
  /// false: α is of each chance row; true: of all of a cycle's together (JointChanceQuantile)
  bool joint_risk = false;

  /// Price of violation per kind, 0: hard. By RowKind; λ_s = 5e3.
  std::array<double, kRowKinds> price = {0, 0, 5e3, 0, 0, 0, 5e3, 5e3};

  constexpr double Price(RowKind kind) const { return price[static_cast<int>(kind)]; }
};

constexpr bool Valid(const ConstraintConfig& c) {
  const bool usable = Usable({c.period_s,
                              c.eta_1ps,
                              c.eta_voxel_1ps,
                              c.eta_self_1ps,
                              c.eta_joint_1ps,
                              c.d_safe_plane_m,
                              c.d_safe_base_plane_m,
                              c.d_safe_pipe_m,
                              c.margin_m,
                              c.voxel_margin_m,
                              c.voxel_noise_m,
                              c.self_margin_m,
                              c.plane_inflation_m,
                              c.plane_behind_m,
                              c.near_vertical_nz,
                              c.pipe_inflation_m,
                              c.consider_m,
                              c.consider_self_m,
                              c.ahead_s,
                              c.recovery_mps,
                              c.alpha});
  const bool rates = c.period_s > 0 && c.eta_1ps > 0 && c.eta_voxel_1ps > 0 && c.eta_self_1ps > 0 &&
                     c.eta_joint_1ps > 0 && c.eta_1ps * c.period_s < 1 &&
                     c.eta_voxel_1ps * c.period_s < 1 && c.eta_self_1ps * c.period_s < 1 &&
                     c.eta_joint_1ps * c.period_s < 1;  // else one period overshoots
  const bool distances = c.d_safe_plane_m >= 0 && c.d_safe_base_plane_m >= 0 &&
                         c.d_safe_pipe_m >= 0 && c.margin_m >= 0 && c.voxel_margin_m >= 0 &&
                         c.voxel_noise_m >= 0 && c.self_margin_m >= 0 && c.plane_inflation_m >= 0 &&
                         c.plane_behind_m >= 0 && c.pipe_inflation_m >= 0 && c.consider_m > 0 &&
                         c.consider_self_m > 0 && c.ahead_s >= 0 && c.recovery_mps >= 0;
  bool prices = c.Price(RowKind::kRecovery) > 0;  // hard, it would leave no answer
  for (const double price : c.price) {
    prices = prices && price >= 0 && Usable(price);
  }
  return usable && rates && distances && prices && c.near_vertical_nz >= 0 &&
         c.near_vertical_nz <= 1 && c.alpha >= 0.5 && c.alpha < 1;
}
static_assert(Valid(ConstraintConfig{}));

}  // namespace pipewright
