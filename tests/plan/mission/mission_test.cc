// SPDX-License-Identifier: MIT
#include "plan/mission/mission.h"

#include <gtest/gtest.h>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "perception/scene.h"
#include "tests/plan/gain/toy_map.h"

namespace pipewright {
namespace {

constexpr Duration kStep = FromSeconds(0.1);

/// The published planner has no paths, so a mission with it needs no robot to move.
MissionConfig PaperMission() {
  MissionConfig config;
  config.planner = PlannerKind::kCfnbvPaper;
  config.paper.candidates = 50;
  return config;
}

class MissionStates : public testing::Test {
 protected:
  MissionStates() { robot_.valid = true; }

  MissionOutput Step(Mission& mission) {
    now_ += kStep;
    return mission.Step(
        {robot_, progress_, map_, field_, scene_, device_fault_, pose_doubted_, pose_lost_}, now_);
  }

  MissionOutput StepUntil(Mission& mission, MissionState state, int steps = 100) {
    MissionOutput out = Step(mission);
    for (int i = 1; i < steps && out.state != state; ++i) {
      out = Step(mission);
    }
    EXPECT_EQ(Name(out.state), Name(state));
    return out;
  }

  void ScatterMap() {
    Rng rng(4);
    test::Scatter(map_, 0.05, 0.5, rng);
  }

  void Answer(const Mission& mission, GoalState state) {
    progress_.id = mission.goal().id;
    progress_.state = state;
  }

  MapConfig map_config_ = test::SmallMapConfig();
  VoxelGrid map_{map_config_};
  DistanceField field_;
  Scene scene_;
  RobotState robot_;
  GoalProgress progress_;
  bool device_fault_ = false;
  bool pose_doubted_ = false;
  bool pose_lost_ = false;
  Time now_{};
};

TEST_F(MissionStates, WaitsForTheDevicesAndGivesUpAfterTheirTimeout) {
  Mission mission(PaperMission(), map_config_);
  robot_.valid = false;
  for (int i = 0; i < 99; ++i) {
    EXPECT_EQ(Step(mission).state, MissionState::kStart);
  }
  const MissionOutput out = StepUntil(mission, MissionState::kFault, 5);
  EXPECT_EQ(out.stop, StopReason::kDeviceFault);
  EXPECT_EQ(mission.goal().id, 0U);
}

TEST_F(MissionStates, EmergencyStopIsNotAStart) {
  Mission mission(PaperMission(), map_config_);
  robot_.emergency_stop = true;
  EXPECT_EQ(Step(mission).state, MissionState::kStart);
  robot_.emergency_stop = false;
  EXPECT_EQ(Step(mission).state, MissionState::kLookAround);
}

TEST_F(MissionStates, PlansMovesAndPlansAgainWhenTheGoalIsReached) {
  ScatterMap();
  Mission mission(PaperMission(), map_config_);
  const MissionOutput moving = StepUntil(mission, MissionState::kMove);
  EXPECT_TRUE(moving.planned);
  EXPECT_TRUE(moving.new_goal);
  EXPECT_EQ(moving.plan_steps, 1);
  EXPECT_EQ(mission.goal().id, 1U);
  EXPECT_FALSE(Step(mission).planned);

  Answer(mission, GoalState::kReached);
  const MissionOutput reached = Step(mission);
  EXPECT_EQ(reached.state, MissionState::kPlan);
  EXPECT_EQ(reached.reached, 1);
  EXPECT_EQ(mission.goal().id, 0U);

  EXPECT_FALSE(Step(mission).planned);  // it settles first
  StepUntil(mission, MissionState::kMove);
  EXPECT_EQ(mission.goal().id, 2U);
}

TEST_F(MissionStates, AnAnswerToAnotherGoalIsNotAnAnswer) {
  ScatterMap();
  Mission mission(PaperMission(), map_config_);
  StepUntil(mission, MissionState::kMove);
  progress_ = {.id = 77, .state = GoalState::kReached};
  EXPECT_EQ(Step(mission).state, MissionState::kMove);
}

TEST_F(MissionStates, StallsWithoutProgressEndIt) {
  ScatterMap();
  MissionConfig config = PaperMission();
  config.stalls_until_stuck = 3;
  Mission mission(config, map_config_);
  for (int stalls = 1; stalls <= 3; ++stalls) {
    StepUntil(mission, MissionState::kMove);
    Answer(mission, GoalState::kStalled);
    EXPECT_EQ(Step(mission).stalls, stalls);
  }
  const MissionOutput out = Step(mission);
  EXPECT_EQ(out.state, MissionState::kDone);
  EXPECT_EQ(out.stop, StopReason::kStuck);
}

TEST_F(MissionStates, StallsWithProgressDoNot) {
  ScatterMap();
  MissionConfig config = PaperMission();
  config.stalls_until_stuck = 2;
  Mission mission(config, map_config_);
  int z = 0;
  for (int stalls = 0; stalls < 6; ++stalls) {
    StepUntil(mission, MissionState::kMove);
    while (map_.State({5, 5, z}) != VoxelState::kUnknown) {
      z = z < 7 ? z + 1 : 0;
      if (z == 7) {
        return;
      }
    }
    test::SetFree(map_, {5, 5, z});
    Answer(mission, GoalState::kStalled);
    EXPECT_EQ(Step(mission).state, MissionState::kPlan);
  }
}

TEST_F(MissionStates, GoalThatIsNeverAnsweredCountsAsStalled) {
  ScatterMap();
  MissionConfig config = PaperMission();
  config.goal_timeout = FromSeconds(2);
  Mission mission(config, map_config_);
  StepUntil(mission, MissionState::kMove);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(Step(mission).state, MissionState::kMove);
  }
  EXPECT_EQ(Step(mission).stalls, 1);
}

TEST_F(MissionStates, CompleteWhenThePlannerSaysSo) {
  test::ForEachVoxel(map_config_.lo, map_config_.hi,
                     [&](const VoxelIndex& v) { test::SetFree(map_, v); });
  Mission mission(PaperMission(), map_config_);
  const MissionOutput out = StepUntil(mission, MissionState::kDone);
  EXPECT_EQ(out.stop, StopReason::kComplete);
  EXPECT_TRUE(out.planned);
  EXPECT_FALSE(Step(mission).planned);
  EXPECT_EQ(Step(mission).state, MissionState::kDone);
}

TEST_F(MissionStates, NoViewSeveralTimesInARowEndsIt) {
  Mission mission(PaperMission(), map_config_);  // nothing is free
  const MissionOutput out = StepUntil(mission, MissionState::kDone);
  EXPECT_EQ(out.stop, StopReason::kNoReachableView);
  EXPECT_EQ(out.plan_steps, 2 * PaperMission().failed_plans_until_stop) << "looks between them";
}

TEST_F(MissionStates, DeviceFaultEndsItAtOnceAndStandsStill) {
  ScatterMap();
  Mission mission(PaperMission(), map_config_);
  StepUntil(mission, MissionState::kMove);
  device_fault_ = true;
  const MissionOutput out = Step(mission);
  EXPECT_EQ(out.state, MissionState::kFault);
  EXPECT_EQ(out.stop, StopReason::kDeviceFault);
  EXPECT_TRUE(out.new_goal);
  EXPECT_EQ(mission.goal().id, 0U);
}

TEST_F(MissionStates, InvalidStateForLongerThanItsTimeoutIsAFault) {
  ScatterMap();
  Mission mission(PaperMission(), map_config_);
  StepUntil(mission, MissionState::kMove);
  robot_.valid = false;
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(Step(mission).state, MissionState::kMove);
  }
  EXPECT_EQ(Step(mission).stop, StopReason::kDeviceFault);
}

TEST_F(MissionStates, APoseThatStaysLostEndsItAndSaysSo) {
  ScatterMap();
  Mission mission(PaperMission(), map_config_);
  StepUntil(mission, MissionState::kMove);
  robot_.valid = false;
  pose_lost_ = true;
  MissionOutput out;
  for (int i = 0; i <= 10; ++i) {
    out = Step(mission);
  }
  EXPECT_EQ(out.state, MissionState::kFault);
  EXPECT_EQ(out.stop, StopReason::kPoseLost);
}

TEST_F(MissionStates, APoseInDoubtDropsTheGoalAndANewPlanFollows) {
  ScatterMap();
  Mission mission(PaperMission(), map_config_);
  StepUntil(mission, MissionState::kMove);
  const std::uint32_t dropped = mission.goal().id;
  pose_doubted_ = true;
  MissionOutput out = Step(mission);
  EXPECT_EQ(out.state, MissionState::kHold);
  EXPECT_TRUE(out.new_goal);
  EXPECT_EQ(mission.goal().id, 0U);
  Answer(mission, GoalState::kReached);  // nobody's
  for (int i = 0; i < 50; ++i) {
    out = Step(mission);
    EXPECT_EQ(out.state, MissionState::kHold);
    EXPECT_FALSE(out.new_goal);
  }
  EXPECT_EQ(out.holds, 1);
  pose_doubted_ = false;
  EXPECT_EQ(Step(mission).state, MissionState::kPlan);
  out = StepUntil(mission, MissionState::kMove);
  EXPECT_EQ(out.plan_steps, 2);
  EXPECT_EQ(out.reached, 0);
  EXPECT_EQ(out.stalls, 0);
  EXPECT_GT(mission.goal().id, dropped);
}

TEST_F(MissionStates, ADoubtThatLastsEndsIt) {
  ScatterMap();
  MissionConfig config = PaperMission();
  config.hold_timeout = FromSeconds(3);
  Mission mission(config, map_config_);
  StepUntil(mission, MissionState::kMove);
  pose_doubted_ = true;
  for (int i = 0; i <= 30; ++i) {
    EXPECT_EQ(Step(mission).state, MissionState::kHold) << i;
  }
  const MissionOutput out = Step(mission);
  EXPECT_EQ(out.state, MissionState::kFault);
  EXPECT_EQ(out.stop, StopReason::kPoseLost);
}

TEST_F(MissionStates, LooksAroundGoOnAfterADoubtAndAStartWaitsForNone) {
  Mission mission(PaperMission(), map_config_);
  pose_doubted_ = true;
  EXPECT_EQ(Step(mission).state, MissionState::kLookAround) << "nothing was placed yet";
  EXPECT_EQ(Step(mission).state, MissionState::kHold);
  pose_doubted_ = false;
  EXPECT_EQ(Step(mission).state, MissionState::kLookAround);
}

TEST_F(MissionStates, EndsByTimeout) {
  ScatterMap();
  MissionConfig config = PaperMission();
  config.mission_timeout = FromSeconds(3);
  Mission mission(config, map_config_);
  const MissionOutput out = StepUntil(mission, MissionState::kDone);
  EXPECT_EQ(out.stop, StopReason::kTimeout);
}

TEST(MissionNames, AreThoseOfTheReport) {
  EXPECT_STREQ(Name(StopReason::kComplete), "complete");
  EXPECT_STREQ(Name(StopReason::kNoReachableView), "no_reachable_view");
  EXPECT_STREQ(Name(StopReason::kDeviceFault), "device_fault");
  EXPECT_STREQ(Name(StopReason::kPoseLost), "pose_lost");
  EXPECT_STREQ(Name(StopReason::kStuck), "stuck");
  EXPECT_STREQ(Name(StopReason::kTimeout), "timeout");
}

}  // namespace
}  // namespace pipewright
