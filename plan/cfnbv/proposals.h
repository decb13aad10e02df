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
  Proposer(const CollisionChecker& checker, const GainEvaluator& gains,
           std::span<const SurfacePatch> surface, const Configuration& q, Rng& rng)
      : checker_(checker), gains_(gains), surface_(surface), q_(q), rng_(rng) {}

  /// One draw of a kind; nothing when it is not free, has no solution or no target.
  std::optional<Configuration> Draw(CandidateKind kind);

 private:
  std::optional<Configuration> Near();
  std::optional<Configuration> Far();
  std::optional<Configuration> AtFrontier();
  std::optional<Configuration> AtUncovered();
  std::optional<Configuration> AtSurface();
  std::optional<Configuration> Look(const Vector3d& from_W, const Vector3d& at_W, double spread);
  bool HasRoom(const Vector3d& p_W) const;
  int Pick(std::size_t count) { return rng_.Index(static_cast<int>(count)); }
  Configuration Somewhere();
  Configuration WithJointNoise(Configuration q, double sigma_rad, int first = 0);
  Vector3d RandomVector();

  const CollisionChecker& checker_;
  const GainEvaluator& gains_;
  const std::span<const SurfacePatch> surface_;
  const Configuration q_;
  Rng& rng_;
};

}  // namespace pipewright
