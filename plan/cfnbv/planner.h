// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "plan/gain/gain.h"
#include "plan/goal.h"
#include "platform/core/status.h"
#include "platform/robot/robot.h"

namespace pipewright {

struct Scene;
class DistanceField;

enum class PlannerKind : std::uint8_t {
  kCfnbv,       ///< reachable candidates, motion cost, stated stopping rule
  kCfnbvPaper,  ///< the published method
};

/// What one planning step may know. The map, the field and the scene are of one moment.
struct PlanInput {
  const VoxelGrid& map;
  const DistanceField& field;
  const Scene& scene;
  Configuration q = Configuration::Zero();  ///< where the robot stands
  GoalState outcome = GoalState::kNone;     ///< how the goal of the last Plan() ended
};

enum class PlanDecision : std::uint8_t {
  kGoal,             ///< go there
  kComplete,         ///< the stopping rule is met
  kNoReachableView,  ///< something is left to see or cover, and no way to it was found
};

constexpr const char* Name(PlanDecision d) {
  switch (d) {
    case PlanDecision::kGoal:
      return "goal";
    case PlanDecision::kComplete:
      return "complete";
    case PlanDecision::kNoReachableView:
      return "no_reachable_view";
  }
  return "?";
}

/// The figures of one decision, for the log.
struct PlanNumbers {
  int candidates = 0;  ///< proposed
  int reachable = 0;   ///< of these, collision-free configurations (paper: not checked, all)
  int paths_tried = 0;
  double gain_visual = 0;  ///< of the chosen view, nats, as its planner counts
  double gain_coverage = 0;
  double gain_weighted = 0;
  double duration_s = 0;      ///< of the path at the planner's speed limits; 0 without a path
  int unknown_targets = 0;    ///< unknown voxels beside known free ones, not residual
  int uncovered_targets = 0;  ///< occupied voxels not covered, not given up
  int given_up = 0;           ///< uncovered voxels that no reachable view was found for
  int residual_new = 0;       ///< unknown voxels to be declared residual by this step
  /// At kComplete: if a share p of the reachable views still gained the threshold, the chance that
  /// all `tested` views missed it would be (1 - p)^tested; this is the p at which that is 1%.
  double share_bound = 0;
  int tested = 0;
};

struct PlanStep {
  Status status = Status::kOk;  ///< kFull: a store was full, what it held was used
  PlanDecision decision = PlanDecision::kNoReachableView;
  Goal goal;  ///< only with kGoal; its id counts up from 1
  PlanNumbers numbers;
};

}  // namespace pipewright
