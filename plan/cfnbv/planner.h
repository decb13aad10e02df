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

/// What a candidate was drawn for.
enum class CandidateKind : std::uint8_t {
  kUniform,    ///< the paper's: anywhere free
  kKept,       ///< a good one that an earlier step did not take
  kNear,       ///< random, near the robot's configuration
  kFar,        ///< random, anywhere about W
  kUnknown,    ///< aimed at a voxel of the frontier
  kUncovered,  ///< aimed at an uncovered voxel
};

constexpr const char* Name(CandidateKind k) {
  switch (k) {
    case CandidateKind::kUniform:
      return "uniform";
    case CandidateKind::kKept:
      return "kept";
    case CandidateKind::kNear:
      return "near";
    case CandidateKind::kFar:
      return "far";
    case CandidateKind::kUnknown:
      return "unknown";
    case CandidateKind::kUncovered:
      return "uncovered";
  }
  return "?";
}

/// The figures of one decision, for the log.
struct PlanNumbers {
  int candidates = 0;  ///< proposed
  int reachable = 0;   ///< of these, collision-free configurations (paper: not checked, all)
  int worthwhile = 0;  ///< of these, above the threshold
  int paths_tried = 0;
  CandidateKind kind = CandidateKind::kUniform;  ///< of the chosen view
  double gain_visual = 0;                        ///< of the chosen view, nats, as counted
  double gain_coverage = 0;
  double gain_weighted = 0;
  double duration_s = 0;      ///< of the path at operating speeds; 0 without a path
  int unknown_targets = 0;    ///< unknown voxels of W that count
  int uncovered_targets = 0;  ///< uncovered voxels of W that count
  int surface_targets = 0;    ///< patches of surface that the probe has not met
  int given_up = 0;           ///< uncovered voxels that do not: views of them failed too often
  int residual_new = 0;       ///< unknown voxels that this step gives up
  int tested = 0;             ///< reachable views that were below the threshold, one after another
  /// If a share p of the reachable views were still above the threshold, all `tested` views would
  /// miss it with probability (1 - p)^tested. This is the p at which that is 1%.
  double share_bound = 1;
};

struct PlanStep {
  Status status = Status::kOk;  ///< kFull: a store was full, what it held was used
  PlanDecision decision = PlanDecision::kNoReachableView;
  Goal goal;  ///< only with kGoal; its id counts up from 1
  PlanNumbers numbers;
};

}  // namespace pipewright
