// SPDX-License-Identifier: MIT
// What the evaluator lists and tallies: the voxels that its gains count.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "plan/gain/gain.h"
#include "tests/plan/gain/gain_fixture.h"

namespace pipewright {
namespace {

using test::Gain;

TEST_F(Gain, ListsHoldFrontierUncoveredAndUnknownVoxels) {
  test::Scatter(map_, 0.1, 0.5, rng_);
  map_.MarkCovered({0.25, 0.25, 0.2}, 0.2);
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  std::vector<VoxelIndex> frontier;
  std::vector<VoxelIndex> uncovered;
  std::vector<VoxelIndex> unknown;
  test::ForEachVoxel(map_config_.workspace_lo, map_config_.workspace_hi, [&](const VoxelIndex& v) {
    const VoxelIndex beside[] = {{v.x - 1, v.y, v.z}, {v.x + 1, v.y, v.z}, {v.x, v.y - 1, v.z},
                                 {v.x, v.y + 1, v.z}, {v.x, v.y, v.z - 1}, {v.x, v.y, v.z + 1}};
    const bool by_free = std::any_of(std::begin(beside), std::end(beside), [&](const auto& n) {
      return map_.State(n) == VoxelState::kFree;
    });
    if (test::Uncovered(map_, v)) {
      uncovered.push_back(v);
    }
    if (test::Unknown(map_, v)) {
      unknown.push_back(v);
    }
    if (test::Unknown(map_, v) && by_free) {
      frontier.push_back(v);
    }
  });
  EXPECT_TRUE(std::ranges::equal(gains.Frontier(), frontier));
  EXPECT_TRUE(std::ranges::equal(gains.Uncovered(), uncovered));
  EXPECT_TRUE(std::ranges::equal(gains.Unknown(), unknown));
}

TEST_F(Gain, IgnoredVoxelsNeitherCountNorAreListed) {
  test::Scatter(map_, 0.1, 0.5, rng_);
  GainEvaluator gains(config_, map_config_);
  const std::vector<std::uint8_t> all(static_cast<std::size_t>(gains.workspace_voxels()), 1);
  gains.Update(map_, all);
  EXPECT_TRUE(gains.Frontier().empty());
  EXPECT_TRUE(gains.Uncovered().empty());
  const Viewpoint view = UprightViewpoint({0.25, 0.25, 0.2}, Vector3d::UnitX());
  const ViewGain gain = gains.EvaluateExact(view, LatticeCameraRays(config_));
  EXPECT_EQ(gain.unknown_voxels + gain.uncovered_voxels, 0);
}

TEST_F(Gain, TallyMarksExactlyWhatCounts) {
  test::Scatter(map_, 0.05, 0.4, rng_);
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  const RaySet camera = LatticeCameraRays(config_);
  for (int i = 0; i < 20; ++i) {
    const Viewpoint view =
        UprightViewpoint(test::RandomPoint(map_config_, rng_), test::RandomDirection(rng_));
    std::vector<std::uint8_t> tally(static_cast<std::size_t>(gains.workspace_voxels()), 0);
    gains.Tally(view, camera, tally);
    const ViewGain gain = gains.EvaluateExact(view, camera);
    EXPECT_EQ(std::count(tally.begin(), tally.end(), 1),
              gain.unknown_voxels + gain.uncovered_voxels);
    gains.Update(map_, tally);
    const ViewGain after = gains.EvaluateExact(view, camera);
    EXPECT_EQ(after.unknown_voxels + after.uncovered_voxels, 0);
    gains.Update(map_);
  }
}

TEST_F(Gain, TallyOnAWayMarksEachVoxelOnceThatTheWayGains) {
  test::Scatter(map_, 0.05, 0.4, rng_);
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  const RaySet camera = LatticeCameraRays(config_);
  std::vector<Viewpoint> way;
  for (int i = 0; i < 5; ++i) {
    way.push_back(
        UprightViewpoint(test::RandomPoint(map_config_, rng_), test::RandomDirection(rng_)));
  }
  int gained = 0;
  gains.BeginWay();
  for (const Viewpoint& view : way) {
    const ViewGain gain = gains.NextOnWay(view, camera);
    gained += gain.unknown_voxels + gain.uncovered_voxels;
  }
  std::vector<std::uint8_t> tally(static_cast<std::size_t>(gains.workspace_voxels()), 0);
  gains.BeginWay();
  for (const Viewpoint& view : way) {
    gains.TallyOnWay(view, camera, tally);
  }
  EXPECT_GT(gained, 0);
  EXPECT_EQ(std::count(tally.begin(), tally.end(), 1), gained);
  EXPECT_EQ(*std::max_element(tally.begin(), tally.end()), 1);
}

}  // namespace
}  // namespace pipewright
