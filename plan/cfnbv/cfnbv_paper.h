// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "perception/map/voxel_index.h"
#include "plan/cfnbv/planner.h"
#include "platform/core/rng.h"

namespace pipewright {

struct CfnbvPaperConfig {
  GainConfig gain;       ///< Table I
  int candidates = 500;  ///< N
  double stop_gain = 1;  ///< stop when the best weighted gain is below; nats
};

constexpr bool Valid(const CfnbvPaperConfig& c) {
  return Valid(c.gain) && c.candidates > 0 && c.stop_gain > 0;
}

/// The published planner. Candidate positions are uniform over the centres of W's free voxels, pan
/// uniform in [-pi, pi), tilt in [-pi/2, pi/2); each has its own random rays; gains count per ray;
/// the goal is the argmax (24) and has no path. kComplete when the best gain is below the stop
/// gain, kNoReachableView when W has no free voxel.
class CfnbvPaper {
 public:
  CfnbvPaper(const CfnbvPaperConfig& config, const MapConfig& map);

  PlanStep Plan(const PlanInput& input, Rng& rng);

 private:
  void CollectFree(const VoxelGrid& map);

  CfnbvPaperConfig config_;
  MapConfig map_;
  GainEvaluator gains_;
  std::vector<Vector3d> free_;  ///< capacity for W, taken at construction
  std::uint32_t next_id_ = 1;
};

}  // namespace pipewright
