// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <functional>

#include "plan/mission/mission.h"
#include "tests/plan/cfnbv/toy_cell.h"

namespace pipewright {
namespace {

/// What becomes of the n-th goal: how much of its path is followed. Less than all is a stall.
using Follower = std::function<double(int n)>;

Goal FirstPart(const Goal& goal, double share) {
  Goal part = goal;
  const int waypoints = static_cast<int>(share * goal.path.size());
  while (part.path.size() > waypoints) {
    part.path.pop_back();
  }
  return part;
}

MissionConfig QuickMission() {
  MissionConfig config = DefaultMission();
  config.cfnbv.stop_uncovered = 4;
  config.cfnbv.stop_tests = 100;
  config.cfnbv.near_candidates = 80;
  config.cfnbv.far_candidates = 40;
  config.cfnbv.far_draws = 400;
  config.cfnbv.unknown_candidates = 60;
  config.cfnbv.uncovered_candidates = 120;
  return config;
}

/// The last goal of a mission, and how long it went on after that.
struct LastGoal {
  Goal goal;
  double rest_s = 0;
};

/// Runs the mission in the cell by a follower without dynamics. @returns the last output
MissionOutput RunMission(test::ToyCell& cell, const MissionConfig& config, const Follower& follow,
                         LastGoal* last = nullptr) {
  Mission mission(config, test::ToyCell::Config());
  RobotState robot;
  robot.valid = true;
  robot.q = test::ToyCell::StartPose();
  GoalProgress progress;
  MissionOutput out;
  double t_s = 0;
  double end_s = 0;
  int goals = 0;
  const auto step = [&] {
    out = mission.Step({robot, progress, cell.map, cell.field, cell.scene}, Time(FromSeconds(t_s)));
    for (const VoxelIndex& v : mission.NewResidual()) {
      cell.map.SetResidual(v, true);
    }
  };
  while (t_s < 2000 && out.state != MissionState::kDone && out.state != MissionState::kFault) {
    step();
    const Goal goal = mission.goal();
    if (goal.id == 0 || goal.id == progress.id) {
      t_s += 0.1;
      continue;
    }
    const double share = follow(goals++);
    t_s += 1 + cell.Follow(FirstPart(goal, share), robot.q);
    end_s = t_s;
    if (last != nullptr) {
      last->goal = goal;
    }
    progress = {
        .id = goal.id, .state = share < 1 ? GoalState::kStalled : GoalState::kReached, .error = 0};
  }
  if (last != nullptr) {
    last->rest_s = t_s - end_s;
  }
  return out;
}

test::ToyCell CellWithOnePipe() {
  test::ToyCell cell({test::ToyCell::ThreePipes()[0]});
  cell.Begin(test::ToyCell::StartPose(), 0.15);
  return cell;
}

TEST(MissionRun, CoversTheCellAndCompletes) {
  test::ToyCell cell = CellWithOnePipe();
  const MissionOutput out = RunMission(cell, QuickMission(), [](int) { return 1.0; });
  EXPECT_STREQ(Name(out.stop), "complete");
  EXPECT_EQ(out.stalls, 0);
  EXPECT_EQ(cell.map.counts().unknown, 0);
  EXPECT_GT(cell.TruthCoverage(), 0.9);
}

TEST(MissionRun, EndsWithALookThatMovesTheArmAlone) {
  test::ToyCell cell = CellWithOnePipe();
  LastGoal last;
  const MissionOutput out = RunMission(
      cell, QuickMission(), [](int) { return 1.0; }, &last);
  EXPECT_STREQ(Name(out.stop), "complete");
  EXPECT_GE(last.rest_s, ToSeconds(QuickMission().last_settle)) << "the pose is to follow";
  const auto& path = last.goal.path;
  EXPECT_EQ((path[0] - path.back()).head<3>().norm(), 0);
  EXPECT_GT((path[0] - path.back()).norm(), 0.1);
  const Surroundings around{cell.field, cell.map, cell.scene};
  const RaySet camera = LatticeCameraRays(QuickMission().cfnbv.gain);
  PoseViews views;
  EXPECT_LT(views.VarianceAfter(path.back(), around, camera),
            views.VarianceAfter(path[0], around, camera));
}

TEST(MissionRun, CompletesThoughEveryFourthGoalStallsOnItsWay) {
  test::ToyCell cell = CellWithOnePipe();
  const MissionOutput out =
      RunMission(cell, QuickMission(), [](int n) { return n % 4 == 3 ? 0.5 : 1.0; });
  EXPECT_STREQ(Name(out.stop), "complete");
  EXPECT_GT(out.stalls, 0);
  EXPECT_GT(cell.TruthCoverage(), 0.9);
}

TEST(MissionRun, RobotThatNeverMovesIsStuck) {
  test::ToyCell cell = CellWithOnePipe();
  const MissionOutput out = RunMission(cell, QuickMission(), [](int) { return 0.0; });
  EXPECT_STREQ(Name(out.stop), "stuck");
}

TEST(MissionRun, RobotWithoutRoomHasNoReachableView) {
  test::ToyCell cell({test::ToyCell::ThreePipes()[0]});
  cell.field.Update(cell.map);
  const MissionOutput out = RunMission(cell, QuickMission(), [](int) { return 1.0; });
  EXPECT_STREQ(Name(out.stop), "no_reachable_view");
  EXPECT_EQ(cell.map.counts().residual, 0);
}

TEST(MissionRun, SameSeedSameRun) {
  int known[2] = {0, 0};
  int plans[2] = {0, 0};
  for (int i = 0; i < 2; ++i) {
    MissionConfig config = QuickMission();
    config.mission_timeout = FromSeconds(20);
    test::ToyCell cell = CellWithOnePipe();
    plans[i] = RunMission(cell, config, [](int) { return 1.0; }).plan_steps;
    known[i] = cell.map.counts().free;
  }
  EXPECT_EQ(known[0], known[1]);
  EXPECT_EQ(plans[0], plans[1]);
}

}  // namespace
}  // namespace pipewright
