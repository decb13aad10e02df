// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "perception/map/voxel_index.h"
#include "plan/cfnbv/planner.h"
#include "plan/motion/collision.h"
#include "platform/core/rng.h"

namespace pipewright {

Viewpoint ViewpointOf(const Configuration& q);

/// Draws collision-free configurations worth a look. What it is given must outlive it.
class Proposer {
 public:
  Proposer(const CollisionChecker& checker, const GainEvaluator& gains, const Configuration& q,
           Rng& rng)
      : checker_(checker), gains_(gains), q_(q), rng_(rng) {}

  /// One draw of a kind; nothing when it is not free, has no solution or no target.
  std::optional<Configuration> Draw(CandidateKind kind);

 private:
  std::optional<Configuration> Near();
  std::optional<Configuration> Far();
  std::optional<Configuration> At(std::span<const VoxelIndex> targets, double distance_min_m,
                                  double distance_max_m, double axis_spread);
  std::optional<Vector3d> Standpoint(const VoxelIndex& target, double distance_min_m,
                                     double distance_max_m);
  Configuration Somewhere();
  Configuration WithJointNoise(Configuration q, double sigma_rad);
  Vector3d RandomVector();

  const CollisionChecker& checker_;
  const GainEvaluator& gains_;
  const Configuration q_;
  Rng& rng_;
};

}  // namespace pipewright
