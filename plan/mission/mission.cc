// SPDX-License-Identifier: MIT
#include "plan/mission/mission.h"

#include <cassert>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "plan/cfnbv/proposals.h"

namespace pipewright {

MissionConfig DefaultMission() {
  MissionConfig config;
  // The wrist alone needs little room: joint 5 swings the camera to the sides, joint 6 nods it.
  constexpr double kLooks[][2] = {{1.0, 0.3}, {-1.0, 0.3}, {0, -0.5}};
  for (const auto& [swing_rad, nod_rad] : kLooks) {
    ArmVector look = ArmVector::Zero();
    look(4) = swing_rad;
    look(5) = nod_rad;
    const bool fits = config.looks.first.push_back(look);
    assert(fits);
    static_cast<void>(fits);
  }
  return config;
}

Mission::Mission(const MissionConfig& config, const MapConfig& map)
    : config_(config),
      looks_(config.looks, config.cfnbv.motion, config.cfnbv.gain),
      rng_(config.seed) {
  assert(Valid(config));
  switch (config.planner) {
    case PlannerKind::kCfnbv:
      planner_.emplace<Cfnbv>(config.cfnbv, map);
      break;
    case PlannerKind::kCfnbvPaper:
      planner_.emplace<CfnbvPaper>(config.paper, map);
      break;
  }
}

std::span<const VoxelIndex> Mission::NewResidual() const {
  const Cfnbv* cfnbv = std::get_if<Cfnbv>(&planner_);
  return cfnbv == nullptr ? std::span<const VoxelIndex>() : cfnbv->NewResidual();
}

MissionOutput Mission::Step(const MissionInput& input, Time now) {
  out_.new_goal = false;
  out_.planned = false;
  if (Ended()) {
    return out_;
  }
  if (!begun_) {
    begun_ = true;
    begin_ = now;
    last_valid_ = now;
  }
  if (DeviceFault(input, now)) {
    const bool lost = input.pose_lost && !input.device_fault;
    End(MissionState::kFault, lost ? StopReason::kPoseLost : StopReason::kDeviceFault);
  } else if (now - begin_ > config_.mission_timeout) {
    End(MissionState::kDone, StopReason::kTimeout);
  }
  if (Cfnbv* cfnbv = std::get_if<Cfnbv>(&planner_);
      cfnbv != nullptr && input.robot.valid && !input.pose_doubted) {
    cfnbv->Passed(input.robot.q);
  }
  if (Hold(input, now)) {
    return out_;
  }
  switch (out_.state) {
    case MissionState::kStart:
      StartStep(input, now);
      break;
    case MissionState::kLookAround:
      LookStep(input, now);
      break;
    case MissionState::kPlan:
      PlanningStep(input, now);
      break;
    case MissionState::kMove:
      MoveStep(input, now);
      break;
    case MissionState::kHold:
    case MissionState::kDone:
    case MissionState::kFault:
      break;
  }
  return out_;
}

/// A pose in doubt: the goal is dropped, for the way to it was planned from elsewhere.
/// @returns whether the robot is to stand in this step
bool Mission::Hold(const MissionInput& input, Time now) {
  if (Ended() || out_.state == MissionState::kStart) {
    return false;
  }
  const bool holding = out_.state == MissionState::kHold;
  if (!input.pose_doubted) {
    if (holding) {
      out_.state = held_;
      settled_at_ = now + config_.settle;
    }
    return false;
  }
  if (!holding) {
    ++out_.holds;
    held_ =
        out_.state == MissionState::kLookAround ? MissionState::kLookAround : MissionState::kPlan;
    out_.state = MissionState::kHold;
    hold_since_ = now;
    out_.new_goal = goal_.id != 0;
    goal_ = Goal{};
  } else if (now - hold_since_ > config_.hold_timeout) {
    End(MissionState::kFault, StopReason::kPoseLost);
  }
  return true;
}

bool Mission::DeviceFault(const MissionInput& input, Time now) {
  if (input.robot.valid && !input.robot.emergency_stop) {
    last_valid_ = now;
  }
  const Duration patience =
      out_.state == MissionState::kStart ? config_.start_timeout : config_.device_timeout;
  return input.device_fault || now - last_valid_ > patience;
}

void Mission::End(MissionState state, StopReason why) {
  out_.state = state;
  out_.stop = why;
  out_.new_goal = goal_.id != 0;
  goal_ = Goal{};
}

/// Gives the goal the next id of the mission: planners and looks number theirs apart.
void Mission::SetGoal(const Goal& goal, Time now) {
  goal_ = goal;
  goal_.id = ++last_goal_id_;
  goal_since_ = now;
  out_.new_goal = true;
}

/// How the goal stands; kMoving until it has ended, or has no time left.
GoalState Mission::FollowGoal(const GoalProgress& progress, Time now) {
  const bool answered = progress.id == goal_.id;
  if (answered && progress.state == GoalState::kReached) {
    return GoalState::kReached;
  }
  if ((answered && progress.state == GoalState::kStalled) ||
      now - goal_since_ > config_.goal_timeout) {
    return GoalState::kStalled;
  }
  return GoalState::kMoving;
}

void Mission::StartStep(const MissionInput& input, Time now) {
  if (!input.robot.valid || input.robot.emergency_stop) {
    return;
  }
  looks_.Begin(LookKind::kFirst, input.robot.q);
  settled_at_ = now + config_.settle;
  out_.state = MissionState::kLookAround;
}

void Mission::LookStep(const MissionInput& input, Time now) {
  if (goal_.id != 0 && FollowGoal(input.progress, now) == GoalState::kMoving) {
    return;
  }
  if (goal_.id != 0) {
    goal_ = Goal{};
    settled_at_ = now + (looks_.kind() == LookKind::kLast ? config_.last_settle : config_.settle);
  }
  if (now < settled_at_) {
    return;
  }
  if (NextLook(input, now)) {
    return;
  }
  if (looks_.kind() == LookKind::kLast) {
    End(MissionState::kDone, ending_);
  } else {
    out_.state = MissionState::kPlan;
  }
}

/// @returns false: there are no more
bool Mission::NextLook(const MissionInput& input, Time now) {
  Goal goal;
  if (!looks_.Next({input.field, input.map, input.scene}, input.robot.q, rng_, goal)) {
    return false;
  }
  ++out_.looks;
  SetGoal(goal, now);
  return true;
}

void Mission::PlanningStep(const MissionInput& input, Time now) {
  if (now < settled_at_) {
    return;
  }
  const PlanInput plan_input{input.map, input.field, input.scene, input.robot.q, last_outcome_};
  Cfnbv* cfnbv = std::get_if<Cfnbv>(&planner_);
  const PlanStep plan = cfnbv != nullptr ? cfnbv->Plan(plan_input, rng_)
                                         : std::get<CfnbvPaper>(planner_).Plan(plan_input, rng_);
  ++out_.plan_steps;
  out_.planned = true;
  out_.plan_status = plan.status;
  out_.decision = plan.decision;
  out_.numbers = plan.numbers;
  last_outcome_ = GoalState::kNone;
  switch (plan.decision) {
    case PlanDecision::kGoal:
      failed_plans_ = 0;
      looking_again_ = false;
      SetGoal(plan.goal, now);
      out_.state = MissionState::kMove;
      return;
    case PlanDecision::kComplete:
      return Finish(input, now, StopReason::kComplete);
    case PlanDecision::kNoReachableView:
      settled_at_ = now + config_.settle;
      if (++failed_plans_ >= config_.failed_plans_until_stop) {
        NoView(input, now);
      }
      return;
  }
}

/// What is in the way may be nothing: a wrong reading that the camera, once it looks from
/// elsewhere, takes back. So some postures about this one are tried, then all that failed before;
/// not twice, if nothing was seen between.
void Mission::NoView(const MissionInput& input, Time now) {
  const MapCounts& counts = input.map.counts();
  const int known = counts.free + counts.occupied;
  if (looking_again_ || known < known_at_no_view_ + config_.cfnbv.forget_voxels) {
    return Finish(input, now, StopReason::kNoReachableView);
  }
  known_at_no_view_ = known;
  looking_again_ = true;
  if (Cfnbv* cfnbv = std::get_if<Cfnbv>(&planner_); cfnbv != nullptr) {
    cfnbv->ForgetFailures();
  }
  failed_plans_ = 0;
  looks_.Begin(LookKind::kAgain, input.robot.q);
  out_.state = MissionState::kLookAround;
}

/// Nothing is left to do. The last way may have shown the camera nothing but the floor, which does
/// not tell where the base is; so it looks once at what does.
void Mission::Finish(const MissionInput& input, Time now, StopReason why) {
  looks_.Begin(LookKind::kLast, input.robot.q);
  ending_ = why;
  if (NextLook(input, now)) {
    out_.state = MissionState::kLookAround;
  } else {
    End(MissionState::kDone, why);
  }
}

void Mission::MoveStep(const MissionInput& input, Time now) {
  const GoalState state = FollowGoal(input.progress, now);
  if (state == GoalState::kMoving) {
    return;
  }
  last_outcome_ = state;
  if (state == GoalState::kReached) {
    ++out_.reached;
    stalls_in_row_ = 0;
  } else {
    NoteStall(input.map.counts());
    if (stalls_in_row_ >= config_.stalls_until_stuck) {
      return End(MissionState::kDone, StopReason::kStuck);
    }
  }
  goal_ = Goal{};
  out_.new_goal = true;
  settled_at_ = now + config_.settle;
  out_.state = MissionState::kPlan;
}

/// Counts a stall, from one again when something was newly seen or covered since the last.
void Mission::NoteStall(const MapCounts& counts) {
  ++out_.stalls;
  const int known = counts.free + counts.occupied;
  const bool progress = known > known_at_stall_ || counts.covered > covered_at_stall_;
  stalls_in_row_ = progress ? 1 : stalls_in_row_ + 1;
  known_at_stall_ = std::max(known, known_at_stall_);
  covered_at_stall_ = std::max(counts.covered, covered_at_stall_);
}

}  // namespace pipewright
