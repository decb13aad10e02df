// SPDX-License-Identifier: MIT
#include "plan/cfnbv/cfnbv_paper.h"

#include <gtest/gtest.h>

#include <numbers>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "perception/scene.h"
#include "tests/plan/gain/toy_map.h"

namespace pipewright {
namespace {

class Paper : public testing::Test {
 protected:
  PlanStep Plan(std::uint64_t seed) {
    Rng rng(seed);
    return CfnbvPaper(config_, map_config_)
        .Plan({.map = map_, .field = field_, .scene = scene_}, rng);
  }

  MapConfig map_config_ = test::SmallMapConfig();
  VoxelGrid map_{map_config_};
  DistanceField field_;
  Scene scene_;
  CfnbvPaperConfig config_;
};

TEST_F(Paper, HasTablesAndSectionsFigures) {
  EXPECT_EQ(config_.candidates, 500);
  EXPECT_EQ(config_.gain.rays, 200);
  EXPECT_DOUBLE_EQ(config_.gain.fov_x_rad, std::numbers::pi / 3);
  EXPECT_DOUBLE_EQ(config_.gain.fov_y_rad, std::numbers::pi / 4);
  EXPECT_EQ(config_.gain.range_m, 3.0);
  EXPECT_EQ(config_.gain.range_min_m, 0);
  EXPECT_EQ(config_.gain.probe_radius_m, 0.4);
  EXPECT_EQ(config_.gain.beta, 0.75);
  EXPECT_EQ(config_.stop_gain, 1);
}

TEST_F(Paper, WithoutAFreeVoxelThereIsNoView) {
  EXPECT_EQ(Plan(1).decision, PlanDecision::kNoReachableView);
}

TEST_F(Paper, GoalIsAFreeVoxelsCentreWithoutAPath) {
  Rng scatter(4);
  test::Scatter(map_, 0.05, 0.5, scatter);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const PlanStep step = Plan(seed);
    ASSERT_EQ(step.decision, PlanDecision::kGoal);
    EXPECT_EQ(step.goal.id, 1U);
    EXPECT_TRUE(step.goal.path.empty());
    const VoxelIndex v = map_.VoxelOf(step.goal.p_WS);
    EXPECT_TRUE(map_.InWorkspace(v));
    EXPECT_EQ(map_.State(v), VoxelState::kFree);
    EXPECT_NEAR((map_.Center(v) - step.goal.p_WS).norm(), 0, 1e-12);
    EXPECT_NEAR(step.goal.z_WS.norm(), 1, 1e-12);
  }
}

TEST_F(Paper, SameSeedSameGoal) {
  Rng scatter(4);
  test::Scatter(map_, 0.05, 0.5, scatter);
  EXPECT_EQ(Plan(3).goal.p_WS, Plan(3).goal.p_WS);
  EXPECT_EQ(Plan(3).goal.z_WS, Plan(3).goal.z_WS);
  EXPECT_NE(Plan(3).goal.p_WS, Plan(4).goal.p_WS);
}

TEST_F(Paper, LooksAtTheOnlyUnknownPart) {
  // All free but a block in one corner of W: the camera must look towards it.
  test::ForEachVoxel(map_config_.lo, map_config_.hi, [&](const VoxelIndex& v) {
    if (!Within(v, {7, 7, 0}, {9, 9, 7})) {
      test::SetFree(map_, v);
    }
  });
  const Vector3d block = map_.Center({8, 8, 4});
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const PlanStep step = Plan(seed);
    ASSERT_EQ(step.decision, PlanDecision::kGoal);
    EXPECT_GT(step.numbers.gain_visual, 0);
    EXPECT_GT((block - step.goal.p_WS).dot(step.goal.z_WS), 0) << seed;
  }
}

TEST_F(Paper, StopsWhenTheBestGainIsBelowOneNat) {
  test::ForEachVoxel(map_config_.lo, map_config_.hi,
                     [&](const VoxelIndex& v) { test::SetFree(map_, v); });
  const PlanStep done = Plan(1);
  EXPECT_EQ(done.decision, PlanDecision::kComplete);
  EXPECT_EQ(done.goal.id, 0U);
  EXPECT_EQ(done.numbers.gain_weighted, 0);

  // One surface voxel turns up: its 200 rays' share is worth more than a nat.
  test::SetOccupied(map_, {5, 5, 4});
  for (int i = 0; i < 4; ++i) {
    test::SetOccupied(map_, {5, 5, 4});
  }
  ASSERT_EQ(map_.State({5, 5, 4}), VoxelState::kOccupied);
  EXPECT_EQ(Plan(1).decision, PlanDecision::kGoal);
}

}  // namespace
}  // namespace pipewright
