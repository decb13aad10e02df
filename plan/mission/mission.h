// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <variant>

#include "plan/cfnbv/cfnbv.h"
#include "plan/cfnbv/cfnbv_paper.h"
#include "plan/mission/looks.h"
#include "platform/core/time.h"

namespace pipewright {

struct MapCounts;

enum class MissionState : std::uint8_t {
  kStart,       ///< waiting for every device to be enabled and fresh
  kLookAround,  ///< arm postures, the base at rest: see LookKind
  kPlan,        ///< the next Step() plans
  kMove,        ///< the controller is on its way
  kHold,        ///< standing until scans and pose agree again, then a new plan
  kDone,        ///< ended as planned: see StopReason
  kFault,       ///< ended by a fault; the goal is "none"
};

enum class StopReason : std::uint8_t {
  kNone,
  kComplete,
  kNoReachableView,
  kDeviceFault,
  kPoseLost,  ///< where the base is became too uncertain to move, or in doubt for too long
  kStuck,     ///< goals stalled in a row while nothing new was seen or covered
  kTimeout,
};

constexpr const char* Name(MissionState s) {
  switch (s) {
    case MissionState::kStart:
      return "start";
    case MissionState::kLookAround:
      return "look_around";
    case MissionState::kPlan:
      return "plan";
    case MissionState::kMove:
      return "move";
    case MissionState::kHold:
      return "hold";
    case MissionState::kDone:
      return "done";
    case MissionState::kFault:
      return "fault";
  }
  return "?";
}

constexpr const char* Name(StopReason r) {
  switch (r) {
    case StopReason::kNone:
      return "none";
    case StopReason::kComplete:
      return "complete";
    case StopReason::kNoReachableView:
      return "no_reachable_view";
    case StopReason::kDeviceFault:
      return "device_fault";
    case StopReason::kPoseLost:
      return "pose_lost";
    case StopReason::kStuck:
      return "stuck";
    case StopReason::kTimeout:
      return "timeout";
  }
  return "?";
}

struct MissionConfig {
  PlannerKind planner = PlannerKind::kCfnbv;
  CfnbvConfig cfnbv;
  CfnbvPaperConfig paper;
  LooksConfig looks;
  Duration start_timeout = FromSeconds(10);  ///< for the devices to come up
  Duration device_timeout = FromSeconds(1);  ///< a state that is invalid for so long is a fault
  Duration goal_timeout = FromSeconds(60);   ///< a goal not reached by then counts as stalled
  Duration hold_timeout = FromSeconds(20);   ///< a pose in doubt for so long is lost
  Duration settle = FromSeconds(0.2);        ///< from a goal's end to the plan: a frame or two
  Duration last_settle = FromSeconds(1);     ///< after the last look, for the pose to follow
  Duration mission_timeout = FromSeconds(3600);
  int stalls_until_stuck = 8;       ///< in a row, with nothing newly seen or covered between
  int failed_plans_until_stop = 8;  ///< kNoReachableView in a row, then again after looks
  std::uint64_t seed = 1;
};

constexpr bool Valid(const MissionConfig& c) {
  return Valid(c.cfnbv) && Valid(c.paper) && c.start_timeout > Duration::zero() &&
         c.device_timeout > Duration::zero() && c.goal_timeout > Duration::zero() &&
         c.hold_timeout > Duration::zero() && Valid(c.looks) && c.settle >= Duration::zero() &&
         c.last_settle >= Duration::zero() && c.mission_timeout > Duration::zero() &&
         c.stalls_until_stuck > 0 && c.failed_plans_until_stop > 0;
}

/// With the looks that suit the UF7's folded posture.
MissionConfig DefaultMission();

/// All that the mission knows in one step. The referents are of one moment, and only read.
struct MissionInput {
  const RobotState& robot;
  const GoalProgress& progress;
  const VoxelGrid& map;
  const DistanceField& field;
  const Scene& scene;
  bool device_fault = false;  ///< a device reports a fault or has stopped answering
  bool pose_doubted = false;  ///< scans do not agree with robot.q
  bool pose_lost = false;     ///< robot is invalid for the base's pose, not for a device
};

struct MissionOutput {
  MissionState state = MissionState::kStart;
  StopReason stop = StopReason::kNone;
  bool new_goal = false;
  bool planned = false;  ///< a plan was made in this step: `plan_status`, `decision`, `numbers`
  Status plan_status = Status::kOk;
  PlanDecision decision = PlanDecision::kNoReachableView;
  PlanNumbers numbers;
  int looks = 0;       ///< taken so far
  int plan_steps = 0;  ///< so far
  int reached = 0;     ///< goals of plans, so far
  int stalls = 0;      ///< likewise
  int holds = 0;       ///< likewise
};

/// Runs one inspection: start, look around, then plan and move until the planner has nothing left,
/// or something ends it. Before it ends as planned, it looks once at what tells where the base is.
/// Pure: no clock, no I/O; a run is a function of its inputs and the seed. Planning happens inside
/// Step() when the state is kPlan (and for each look); all other steps take microseconds. All
/// memory is taken at construction.
class Mission {
 public:
  Mission(const MissionConfig& config, const MapConfig& map);

  MissionOutput Step(const MissionInput& input, Time now);

  /// What the controller is to do now; id 0 is "stand still". Changes only in Step().
  const Goal& goal() const { return goal_; }

  /// Unknown voxels that the last planning step gave up; the map's owner is to mark them residual.
  std::span<const VoxelIndex> NewResidual() const;

 private:
  bool Ended() const {
    return out_.state == MissionState::kDone || out_.state == MissionState::kFault;
  }
  bool DeviceFault(const MissionInput& input, Time now);
  void End(MissionState state, StopReason why);
  void SetGoal(const Goal& goal, Time now);
  GoalState FollowGoal(const GoalProgress& progress, Time now);
  bool Hold(const MissionInput& input, Time now);
  void StartStep(const MissionInput& input, Time now);
  void LookStep(const MissionInput& input, Time now);
  bool NextLook(const MissionInput& input, Time now);
  void Finish(const MissionInput& input, Time now, StopReason why);
  void PlanningStep(const MissionInput& input, Time now);
  void NoView(const MissionInput& input, Time now);
  void MoveStep(const MissionInput& input, Time now);
  void NoteStall(const MapCounts& counts);

  MissionConfig config_;
  std::variant<std::monostate, Cfnbv, CfnbvPaper> planner_;
  Looks looks_;
  Rng rng_;
  Goal goal_;
  MissionOutput out_;
  bool begun_ = false;
  Time begin_{};
  Time last_valid_{};
  Time goal_since_{};
  Time settled_at_{};
  Time hold_since_{};
  MissionState held_ = MissionState::kPlan;  ///< what to go on with
  bool looking_again_ = false;               ///< since no view could be reached
  StopReason ending_ = StopReason::kNone;    ///< after the last look
  std::uint32_t last_goal_id_ = 0;
  GoalState last_outcome_ = GoalState::kNone;
  int failed_plans_ = 0;
  int known_at_no_view_ = std::numeric_limits<int>::min() / 2;  ///< voxels, at the last NoView()
  int stalls_in_row_ = 0;
  int known_at_stall_ = 0;
  int covered_at_stall_ = 0;
};

}  // namespace pipewright
