// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>

#include "plan/cfnbv/planner.h"
#include "platform/core/rng.h"

namespace pipewright {

struct CfnbvConfig {
  GainConfig gain{.range_min_m = 0.17};
  double horizon_s = 10;        ///< t0 of the score G_w / (t0 + t): what a view costs beside motion
  int random_candidates = 60;   ///< configurations drawn at random a step, near and far
  int unknown_candidates = 60;  ///< configurations aimed at frontier voxels a step
  int coverage_candidates = 60;   ///< configurations aimed at uncovered voxels a step
  int paths = 6;                  ///< how many motion plans a step may try
  double stop_unknown = 4;        ///< a view of fewer new voxels than this, and
  double stop_uncovered = 1;      ///< fewer uncovered ones than this, is not worth the way
  int stop_tests = 400;           ///< reachable views that must fail in a row before kComplete
  int tries_per_voxel = 3;        ///< aimed views that may fail before a voxel is given up
  double stall_penalty_m = 0.15;  ///< views this near to one that stalled are not taken again
};

constexpr bool Valid(const CfnbvConfig& c) {
  return Valid(c.gain) && c.horizon_s > 0 && c.random_candidates >= 0 &&
         c.unknown_candidates >= 0 && c.coverage_candidates >= 0 &&
         c.random_candidates + c.unknown_candidates + c.coverage_candidates > 0 && c.paths > 0 &&
         c.stop_unknown >= 1 && c.stop_uncovered >= 1 && c.stop_tests > 0 &&
         c.tries_per_voxel > 0 && c.stall_penalty_m >= 0;
}

/// The default planner: coverage first next best view over configurations that the robot can reach.
///
/// Candidates are collision-free configurations: aimed at uncovered voxels and at unknown voxels on
/// the frontier (by inverse kinematics), random near the robot and anywhere. Each is scored by its
/// distinct gain (23) over the time that going there takes; the best for which a path is found is
/// the goal, with its path.
///
/// It stops (kComplete) when `stop_tests` reachable views in a row, aimed at everything that is
/// left and random, gain less than the threshold. What is left then is declared: unknown voxels as
/// residual, uncovered ones as given up.
class Cfnbv {
 public:
  Cfnbv(const CfnbvConfig& config, const MapConfig& map);
  ~Cfnbv();
  Cfnbv(const Cfnbv&) = delete;
  Cfnbv& operator=(const Cfnbv&) = delete;

  PlanStep Plan(const PlanInput& input, Rng& rng);

  /// Unknown voxels that the last Plan() found no view for; the map's owner marks them residual.
  std::span<const VoxelIndex> NewResidual() const;

 private:
  struct Memory;

  CfnbvConfig config_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace pipewright
