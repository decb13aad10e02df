// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <variant>

#include "plan/cfnbv/cfnbv.h"
#include "plan/cfnbv/cfnbv_paper.h"
#include "platform/core/time.h"

namespace pipewright {

enum class MissionState : std::uint8_t {
  kStart,       ///< waiting for every device to be enabled and fresh
  kLookAround,  ///< arm postures about the start, so that more than the start bubble is known
  kPlan,        ///< the next Step() plans
  kMove,        ///< the controller is on its way
  kDone,        ///< ended as planned: see StopReason
  kFault,       ///< ended by a fault; the goal is "none"
};

enum class StopReason : std::uint8_t {
  kNone,
  kComplete,
  kNoReachableView,
  kDeviceFault,
  kStuck,  ///< goals stalled in a row while nothing new was seen or covered
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
    case StopReason::kStuck:
      return "stuck";
    case StopReason::kTimeout:
      return "timeout";
  }
  return "?";
}

struct MissionConfig {
  static constexpr int kMaxPostures = 16;

  PlannerKind planner = PlannerKind::kCfnbv;
  CfnbvConfig cfnbv;
  CfnbvPaperConfig paper;
  /// Looks to take first: arm joint angles minus those at the start, rad. One that would collide is
  /// halved until it does not, at most twice, and else left out.
  FixedVector<ArmVector, kMaxPostures> look_around;
  Duration start_timeout = FromSeconds(10);  ///< for the devices
  Duration goal_timeout = FromSeconds(60);   ///< a goal not reached by then counts as stalled
  Duration settle = FromSeconds(0.2);        ///< between a goal's end and the plan: a frame or two
  Duration mission_timeout = FromSeconds(3600);
  int stalls_until_stuck = 6;
  int failed_plans_until_stop = 3;  ///< kNoReachableView in a row, with frames between
  std::uint64_t seed = 1;
};

/// The looks that suit the UF7's folded posture.
MissionConfig DefaultMission();

/// All that the mission knows in one step. The referents are of one moment, and only read.
struct MissionInput {
  const RobotState& robot;
  const GoalProgress& progress;
  const VoxelGrid& map;
  const DistanceField& field;
  const Scene& scene;
  bool device_fault = false;  ///< a device reports a fault or has stopped answering
};

struct MissionOutput {
  MissionState state = MissionState::kStart;
  StopReason stop = StopReason::kNone;
  bool new_goal = false;
  bool planned = false;  ///< `numbers` and `decision` are of this step
  PlanDecision decision = PlanDecision::kNoReachableView;
  PlanNumbers numbers;
  int plan_steps = 0;  ///< so far
  int stalls = 0;      ///< so far
};

/// Runs one inspection: start, look around, then plan and move until the planner has nothing left,
/// or something ends it. Pure: no clock, no I/O; a run is a function of its inputs and the seed.
/// Planning happens inside Step() when the state is kPlan; all other steps take microseconds.
class Mission {
 public:
  Mission(const MissionConfig& config, const MapConfig& map);

  MissionOutput Step(const MissionInput& input, Time now);

  /// What the controller is to do now; id 0 is "stand still".
  const Goal& goal() const { return goal_; }

  /// Unknown voxels that the last planning step gave up; the map's owner marks them residual.
  std::span<const VoxelIndex> NewResidual() const;

 private:
  MissionConfig config_;
  std::variant<std::monostate, Cfnbv, CfnbvPaper> planner_;
  Rng rng_;
  Goal goal_;
  MissionOutput out_;
};

}  // namespace pipewright
