// SPDX-License-Identifier: MIT
#include "plan/gain/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "perception/map/voxel_grid.h"
#include "perception/scene.h"
#include "plan/gain/gain.h"
#include "tests/plan/gain/toy_map.h"

namespace pipewright {
namespace {

constexpr int kFrames = 3;

PipeEstimate Pipe() {
  PipeEstimate pipe;
  pipe.p_W = {0.26, 0.24, 0.2};
  pipe.l_W = Vector3d::UnitY();
  pipe.radius_m = 0.06;
  pipe.extent_lo_m = -0.1;
  pipe.extent_hi_m = 0.1;
  pipe.frames_seen = kFrames;
  return pipe;
}

class Surface : public testing::Test {
 protected:
  Surface() { EXPECT_TRUE(scene_.pipes.push_back(Pipe())); }

  MapConfig map_config_ = test::SmallMapConfig();
  VoxelGrid map_{map_config_};
  Scene scene_;
  SurfaceToCover surface_{map_config_};
};

TEST_F(Surface, PatchesLieOnTheSeenCylinder) {
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  // 0.2 m at 0.025 m by 2 pi 0.06 m at 0.0125 m: 8 by 31.
  ASSERT_EQ(surface_.patches().size(), 248U);
  for (const SurfacePatch& patch : surface_.patches()) {
    const Vector3d from_axis = patch.p_W - scene_.pipes[0].p_W;
    EXPECT_LE(std::abs(from_axis.y()), 0.1);
    const Vector3d across(from_axis.x(), 0, from_axis.z());
    EXPECT_NEAR(across.norm(), 0.06, 1e-12);
    EXPECT_NEAR((across / 0.06 - patch.n_W).norm(), 0, 1e-12);
    EXPECT_EQ(patch.voxel, map_.VoxelOf(patch.p_W));
  }
}

TEST_F(Surface, EveryVoxelThatASliverOfThePipeCrossesHasAPatch) {
  constexpr int kAround = 3600;
  for (int shift = 0; shift < 20; ++shift) {
    scene_.pipes[0].p_W = {0.24 + 0.0025 * shift, 0.24, 0.26 - 0.0017 * shift};
    ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
    std::map<std::pair<int, int>, int> crossed;  // x, z: samples of the ring
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      const VoxelIndex v =
          map_.VoxelOf(scene_.pipes[0].p_W + 0.06 * Vector3d(std::cos(angle), 0, std::sin(angle)));
      ++crossed[{v.x, v.z}];
    }
    for (const auto& ring : crossed) {
      const std::pair<int, int>& voxel = ring.first;
      const double arc_m = 2 * std::numbers::pi * 0.06 * ring.second / kAround;
      const bool has_patch = std::any_of(
          surface_.patches().begin(), surface_.patches().end(), [&](const SurfacePatch& patch) {
            return patch.voxel.x == voxel.first && patch.voxel.z == voxel.second;
          });
      EXPECT_TRUE(has_patch || arc_m < 0.0125) << shift << ": " << arc_m;
    }
  }
}

TEST_F(Surface, WantsFramesAndWAndPositiveMeasures) {
  EXPECT_EQ(surface_.Update(map_, scene_, kFrames + 1), Status::kOk);
  EXPECT_TRUE(surface_.patches().empty());
  scene_.pipes[0].p_W.x() = 2;
  EXPECT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  EXPECT_TRUE(surface_.patches().empty());
  scene_.pipes[0] = Pipe();
  scene_.pipes[0].extent_hi_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  EXPECT_TRUE(surface_.patches().empty());
}

TEST_F(Surface, FullStoreSaysSoAndKeepsWhatItHolds) {
  SurfaceToCover small(map_config_, 20);
  EXPECT_EQ(small.Update(map_, scene_, kFrames), Status::kFull);
  EXPECT_EQ(small.patches().size(), 20U);
}

TEST_F(Surface, WhatIsMetDoesNotComeBackWhenTheEstimateSettles) {
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  const std::vector<SurfacePatch> all(surface_.patches().begin(), surface_.patches().end());
  for (const SurfacePatch& patch : all) {
    surface_.MarkMet(patch);
  }
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  EXPECT_TRUE(surface_.patches().empty());
  scene_.pipes[0].radius_m += 0.003;
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  EXPECT_LT(surface_.patches().size(), all.size() / 10);
}

TEST_F(Surface, FacesTowardsFreeVoxelsArePatchesUntilTheyAreMet) {
  scene_.pipes.clear();
  test::SetOccupied(map_, {5, 5, 4});
  test::SetFree(map_, {6, 5, 4});
  test::SetFree(map_, {5, 5, 3});
  test::SetFree(map_, {5, 4, 4});
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  ASSERT_EQ(surface_.patches().size(), 3U);  // the other three sides are unknown
  for (const SurfacePatch& patch : surface_.patches()) {
    EXPECT_EQ(patch.voxel, (VoxelIndex{5, 5, 4}));
    EXPECT_EQ(map_.VoxelOf(patch.p_W), patch.voxel);
    EXPECT_EQ(map_.State(map_.VoxelOf(patch.p_W + 0.01 * patch.n_W)), VoxelState::kFree);
  }
  surface_.MarkMet(SurfacePatch(surface_.patches()[0]));
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  EXPECT_EQ(surface_.patches().size(), 2U);
}

TEST_F(Surface, FaceOfTheNextVoxelInFrontIsMetToo) {
  scene_.pipes.clear();
  test::SetOccupied(map_, {5, 5, 4});
  test::SetFree(map_, {6, 5, 4});
  test::SetFree(map_, {7, 5, 4});
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  ASSERT_EQ(surface_.patches().size(), 1U);
  surface_.MarkMet(SurfacePatch(surface_.patches()[0]));
  for (int i = 0; i < 4; ++i) {
    test::SetOccupied(map_, {6, 5, 4});
  }
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  EXPECT_TRUE(surface_.patches().empty());
}

TEST_F(Surface, IsMetFromTheSideItFacesWithinTheRadiusAndInSight) {
  GainConfig config;
  config.probe_radius_m = 0.2;
  GainEvaluator gains(config, map_config_);
  gains.Update(map_);
  const SurfacePatch patch{{0.26, 0.24, 0.26}, Vector3d::UnitZ(), map_.VoxelOf({0.26, 0.24, 0.26})};
  EXPECT_TRUE(gains.SurfaceMet({0.26, 0.24, 0.45}, patch));
  EXPECT_FALSE(gains.SurfaceMet({0.26, 0.24, 0.47}, patch));  // beyond the radius
  EXPECT_FALSE(gains.SurfaceMet({0.26, 0.24, 0.10}, patch));  // from behind
  EXPECT_FALSE(gains.SurfaceMet({0.44, 0.24, 0.26}, patch));  // along it
  EXPECT_FALSE(gains.SurfaceMet({0.26, 0.24, 9}, patch));     // outside the box

  test::SetOccupied(map_, map_.VoxelOf({0.26, 0.24, 0.26}));  // its own voxel hides nothing
  gains.Update(map_);
  EXPECT_TRUE(gains.SurfaceMet({0.26, 0.24, 0.45}, patch));
  test::SetOccupied(map_, map_.VoxelOf({0.26, 0.24, 0.38}));
  gains.Update(map_);
  EXPECT_FALSE(gains.SurfaceMet({0.26, 0.24, 0.45}, patch));
}

TEST_F(Surface, VoxelsOfMetPatchesCountOnceAmongTheUncovered) {
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  GainConfig config;
  config.probe_radius_m = 0.25;
  GainEvaluator gains(config, map_config_);
  gains.Update(map_);
  gains.SetSurface(surface_.patches());
  Viewpoint view;
  view.p_WP = {0.26, 0.24, 0.44};
  std::set<int> voxels;
  for (const SurfacePatch& patch : surface_.patches()) {
    if (gains.SurfaceMet(view.p_WP, patch)) {
      voxels.insert(map_.IndexOf(patch.voxel));
    }
  }
  EXPECT_GT(voxels.size(), 5U);
  EXPECT_EQ(gains.EvaluateExact(view, RaySet{}).uncovered_voxels, static_cast<int>(voxels.size()));

  std::vector<std::uint8_t> tally(static_cast<std::size_t>(gains.workspace_voxels()), 0);
  gains.Tally(view, RaySet{}, tally);
  EXPECT_EQ(std::count(tally.begin(), tally.end(), 1), static_cast<int>(voxels.size()));
  gains.Update(map_, tally);
  gains.SetSurface(surface_.patches());
  EXPECT_EQ(gains.EvaluateExact(view, RaySet{}).uncovered_voxels, 0);
}

TEST_F(Surface, WayCountsEachVoxelOnce) {
  ASSERT_EQ(surface_.Update(map_, scene_, kFrames), Status::kOk);
  GainConfig config;
  config.probe_radius_m = 0.25;
  GainEvaluator gains(config, map_config_);
  gains.Update(map_);
  gains.SetSurface(surface_.patches());
  const RaySet camera = LatticeCameraRays(config);
  const Viewpoint view = UprightViewpoint({0.26, 0.24, 0.44}, -Vector3d::UnitZ());
  const ViewGain alone = gains.EvaluateExact(view, camera);
  gains.BeginWay();
  EXPECT_EQ(gains.NextOnWay(view.p_WP).uncovered_voxels, alone.uncovered_voxels);
  EXPECT_EQ(gains.NextOnWay(view, camera).unknown_voxels, alone.unknown_voxels);
  const ViewGain again = gains.NextOnWay(view, camera);
  EXPECT_EQ(again.unknown_voxels + again.uncovered_voxels, 0);
}

}  // namespace
}  // namespace pipewright
