// SPDX-License-Identifier: MIT
#include "plan/cfnbv/cfnbv.h"

#include <gtest/gtest.h>

#include "plan/cfnbv/failures.h"
#include "plan/cfnbv/open_rays.h"
#include "plan/cfnbv/proposals.h"
#include "plan/motion/collision.h"
#include "tests/plan/cfnbv/toy_cell.h"

namespace pipewright {
namespace {

constexpr double kStartClearance_m = 0.15;

PlanInput InputOf(const test::ToyCell& cell, const Configuration& q,
                  GoalState outcome = GoalState::kNone) {
  return {.map = cell.map, .field = cell.field, .scene = cell.scene, .q = q, .outcome = outcome};
}

void ApplyResidual(test::ToyCell& cell, const Cfnbv& planner) {
  for (const VoxelIndex& v : planner.NewResidual()) {
    cell.map.SetResidual(v, true);
  }
}

TEST(Cfnbv, GoalIsACollisionFreePathToAViewOfItsGain) {
  test::ToyCell cell(test::ToyCell::ThreePipes());
  Configuration q = test::ToyCell::StartPose();
  cell.Begin(q, kStartClearance_m);
  CfnbvConfig config;
  config.tries_per_voxel = 254;  // nothing is ignored
  Cfnbv planner(config, test::ToyCell::Config());
  Rng rng(1);
  GoalState outcome = GoalState::kNone;
  for (std::uint32_t i = 1; i <= 5; ++i) {
    const PlanStep step = planner.Plan(InputOf(cell, q, outcome), rng);
    ASSERT_EQ(step.decision, PlanDecision::kGoal) << i;
    EXPECT_EQ(step.goal.id, i);
    ASSERT_GE(step.goal.path.size(), 2);
    EXPECT_EQ(step.goal.path[0], q);
    const Viewpoint end = ViewpointOf(step.goal.path.back());
    EXPECT_NEAR((end.X_WS.translation() - step.goal.p_WS).norm(), 0, 1e-9);
    EXPECT_NEAR((end.X_WS.linear().col(2) - step.goal.z_WS).norm(), 0, 1e-9);
    const CollisionChecker checker({cell.field, cell.map, cell.scene}, config.motion.collision);
    EXPECT_TRUE(checker.Free(step.goal.path.back()));

    GainEvaluator gains(config.gain, test::ToyCell::Config());
    gains.Update(cell.map);
    RaySet open;
    OpenRays(step.goal.path.back(), LatticeCameraRays(config.gain), open);
    const ViewGain gain = gains.EvaluateExact(end, open);
    EXPECT_GE(step.numbers.gain_visual,
              gain.visual_nats - 1e-9);  // the way gains more than its end
    EXPECT_GE(step.numbers.gain_coverage, gain.coverage_nats - 1e-9);
    cell.Follow(step.goal, q);
    outcome = GoalState::kReached;
  }
}

TEST(Cfnbv, ClearsTheCellAndStops) {
  test::ToyCell cell({test::ToyCell::ThreePipes()[0]});
  Configuration q = test::ToyCell::StartPose();
  cell.Begin(q, kStartClearance_m);
  CfnbvConfig config;
  config.stop_uncovered = 3;
  config.stop_tests = 150;
  Cfnbv planner(config, test::ToyCell::Config());
  Rng rng(2);
  GoalState outcome = GoalState::kNone;
  PlanDecision decision = PlanDecision::kGoal;
  for (int i = 0; i < 150 && decision != PlanDecision::kComplete; ++i) {
    const PlanStep step = planner.Plan(InputOf(cell, q, outcome), rng);
    decision = step.decision;
    outcome = GoalState::kNone;
    ApplyResidual(cell, planner);
    if (decision == PlanDecision::kGoal) {
      cell.Follow(step.goal, q, [&](const Configuration& at) { planner.Passed(at); });
      outcome = GoalState::kReached;
    } else if (decision == PlanDecision::kComplete) {
      const PlanNumbers& n = step.numbers;
      if (n.unknown_targets + n.uncovered_targets + n.surface_targets > 0) {
        EXPECT_GE(step.numbers.tested, 150);
        EXPECT_LT(step.numbers.share_bound, 0.05);
      }
      EXPECT_EQ(cell.map.counts().unknown, 0);  // the rest is declared residual
    }
  }
  EXPECT_STREQ(Name(decision), "complete");
  const MapCounts& counts = cell.map.counts();
  EXPECT_GT(counts.covered, 0.9 * counts.occupied);  // views of fewer than three are not taken
  EXPECT_GT(cell.TruthCoverage(), 0.95);  // of all surface, whether it can be covered or not
  EXPECT_GT(counts.free + counts.occupied, 0.85 * counts.total);
}

TEST(Cfnbv, SameSeedSameGoals) {
  Goal goals[2];
  for (Goal& goal : goals) {
    test::ToyCell cell(test::ToyCell::ThreePipes());
    const Configuration q = test::ToyCell::StartPose();
    cell.Begin(q, kStartClearance_m);
    Cfnbv planner(CfnbvConfig{}, test::ToyCell::Config());
    Rng rng(5);
    goal = planner.Plan(InputOf(cell, q), rng).goal;
  }
  EXPECT_EQ(goals[0].p_WS, goals[1].p_WS);
  ASSERT_EQ(goals[0].path.size(), goals[1].path.size());
  for (int i = 0; i < goals[0].path.size(); ++i) {
    EXPECT_EQ(goals[0].path[i], goals[1].path[i]);
  }
}

TEST(Cfnbv, BoxedInRobotHasNoReachableViewRatherThanAWorkDone) {
  test::ToyCell cell(test::ToyCell::ThreePipes());
  const Configuration q = test::ToyCell::StartPose();
  // Never saw anything, and knows nothing but its own body.
  cell.field.Update(cell.map);
  Cfnbv planner(CfnbvConfig{}, test::ToyCell::Config());
  Rng rng(6);
  const PlanStep step = planner.Plan(InputOf(cell, q), rng);
  EXPECT_EQ(step.decision, PlanDecision::kNoReachableView);
  EXPECT_EQ(step.numbers.reachable, 0);
  EXPECT_TRUE(planner.NewResidual().empty());
}

TEST(Cfnbv, ViewThatStalledTwiceIsNotTakenAgain) {
  test::ToyCell cell(test::ToyCell::ThreePipes());
  const Configuration q = test::ToyCell::StartPose();
  cell.Begin(q, kStartClearance_m);
  const CfnbvConfig config;
  Cfnbv planner(config, test::ToyCell::Config());
  Failures stalls(1, 1, config.stall_radius_m);
  Rng rng(7);
  GoalState outcome = GoalState::kNone;
  for (int i = 0; i < 8; ++i) {
    const PlanStep step = planner.Plan(InputOf(cell, q, outcome), rng);
    if (step.decision != PlanDecision::kGoal) {
      return;
    }
    const Viewpoint view = ViewpointOf(step.goal.path.back());
    EXPECT_LT(stalls.StallsNear(view), 2) << i;
    stalls.AddStall(view);
    outcome = GoalState::kStalled;
  }
}

TEST(Failures, VoxelIsIgnoredAfterItsTriesAndPathlessOnesComeBack) {
  Failures failures(3, 2, 0.1);
  failures.unsettled()[0] = 2;
  failures.pathless()[1] = 2;
  failures.pathless()[2] = 1;
  failures.Refresh();
  EXPECT_EQ(failures.Ignored()[0], 1);
  EXPECT_EQ(failures.Ignored()[1], 1);
  EXPECT_EQ(failures.Ignored()[2], 0);
  failures.ForgetPathless();
  failures.Refresh();
  EXPECT_EQ(failures.Ignored()[0], 1);
  EXPECT_EQ(failures.Ignored()[1], 0);
}

TEST(Failures, StallsCountByPlaceAndDirectionAndTheOldestAreForgotten) {
  Failures failures(1, 1, 0.1);
  const Viewpoint view = UprightViewpoint({1, 1, 1}, Vector3d::UnitX());
  EXPECT_EQ(failures.StallsNear(view), 0);
  failures.AddStall(view);
  failures.AddStall(UprightViewpoint({1.05, 1, 1}, Vector3d::UnitX()));
  failures.AddStall(UprightViewpoint({1.2, 1, 1}, Vector3d::UnitX()));
  failures.AddStall(UprightViewpoint({1, 1, 1}, Vector3d::UnitY()));
  EXPECT_EQ(failures.StallsNear(view), 2);
  for (int i = 0; i < 64; ++i) {
    failures.AddStall(UprightViewpoint({9, 9, 9}, Vector3d::UnitX()));
  }
  EXPECT_EQ(failures.StallsNear(view), 0);
}

}  // namespace
}  // namespace pipewright
