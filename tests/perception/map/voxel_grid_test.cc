// SPDX-License-Identifier: MIT
#include "perception/map/voxel_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "platform/core/rng.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

const double kLn2 = std::log(2.0);

void Hit(VoxelGrid* grid, const VoxelIndex& v) {
  const Vector3f center = grid->Center(v).cast<float>();
  grid->InsertScan(&center, 1, center, -1);
}

// One miss: a ray from v's centre into the neighbour above, which is hit.
void Miss(VoxelGrid* grid, const VoxelIndex& v) {
  const Vector3f from = grid->Center(v).cast<float>();
  const Vector3f to = grid->Center({v.x, v.y, v.z + 1}).cast<float>();
  grid->InsertScan(&to, 1, from, -1);
}

MapCounts Recount(const VoxelGrid& grid) {
  MapCounts n;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    if (grid.InWorkspace(v)) {
      ++n.total;
      n.free += grid.State(v) == VoxelState::kFree ? 1 : 0;
      n.occupied += grid.State(v) == VoxelState::kOccupied ? 1 : 0;
      n.residual += grid.Residual(v) ? 1 : 0;
      n.unknown += grid.State(v) == VoxelState::kUnknown && !grid.Residual(v) ? 1 : 0;
      n.covered += grid.Covered(v) ? 1 : 0;
    }
  }
  return n;
}

double VisualEntropy(const VoxelGrid& grid) {
  double sum = 0;
  int total = 0;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    if (grid.InWorkspace(v)) {
      const double p = 1 / (1 + std::exp(-static_cast<double>(grid.LogOdds(v))));
      sum += -p * std::log(p) - (1 - p) * std::log(1 - p);
      ++total;
    }
  }
  return sum / total;
}

void ExpectCountsAreTrue(const VoxelGrid& grid) {
  const MapCounts kept = grid.counts();
  const MapCounts n = Recount(grid);
  EXPECT_EQ(kept.total, n.total);
  EXPECT_EQ(kept.free, n.free);
  EXPECT_EQ(kept.occupied, n.occupied);
  EXPECT_EQ(kept.unknown, n.unknown);
  EXPECT_EQ(kept.residual, n.residual);
  EXPECT_EQ(kept.covered, n.covered);
  EXPECT_EQ(n.total, n.free + n.occupied + n.unknown + n.residual);
  EXPECT_NEAR(grid.visual_entropy(), VisualEntropy(grid), 1e-7);
  EXPECT_NEAR(grid.coverage_entropy(), (n.occupied - n.covered) * kLn2 / n.total, 1e-12);
  EXPECT_EQ(grid.combined_entropy(), grid.visual_entropy() + grid.coverage_entropy());
}

TEST(VoxelGrid, StartsUnknownEverywhere) {
  const VoxelGrid grid(test::Box(5));
  EXPECT_EQ(grid.counts().unknown, 1000);
  EXPECT_NEAR(grid.visual_entropy(), kLn2, 1e-15);
  EXPECT_EQ(grid.coverage_entropy(), 0);
  EXPECT_EQ(grid.bricks_used(), 0);
  ExpectCountsAreTrue(grid);
}

TEST(VoxelGrid, KeepsCountsAndEntropiesTrueThroughAnyHistory) {
  MapConfig config = test::Box(12);
  config.workspace_lo = {-9, -7, -12};
  config.workspace_hi = {8, 11, 5};
  VoxelGrid grid(config);
  Rng rng(1);
  const auto somewhere = [&](double reach) {
    return Vector3d(rng.Uniform(-reach, reach), rng.Uniform(-reach, reach),
                    rng.Uniform(-reach, reach));
  };
  for (int round = 0; round < 60; ++round) {
    const Vector3f origin = somewhere(0.4).cast<float>();
    std::vector<Vector3f> points;
    for (int i = 0; i < 30; ++i) {
      points.emplace_back(somewhere(0.8).cast<float>());
    }
    grid.InsertScan(points.data(), 30, origin, round % 2 == 0 ? -1 : 0.5);
    grid.MarkSweptSphere(somewhere(0.7), 0.1);
    for (int i = 0; i < 50; ++i) {
      grid.SetResidual(grid.VoxelAt(rng.Index(grid.voxel_count())), rng.Index(3) > 0);
    }
    grid.MarkCovered(somewhere(0.6), 0.3);
    ExpectCountsAreTrue(grid);
  }
  EXPECT_GT(grid.counts().covered, 20);
  EXPECT_GT(grid.counts().residual, 20);
}

TEST(VoxelGrid, AVoxelThatTurnsFreeIsNoLongerCovered) {
  VoxelGrid grid(test::Box(8));
  const VoxelIndex v{1, 2, 3};
  Hit(&grid, v);
  EXPECT_EQ(grid.MarkCovered(grid.Center({1, 2, 0}), 0.4), 1);
  EXPECT_TRUE(grid.Covered(v));
  EXPECT_EQ(grid.MarkCovered(grid.Center({1, 2, 0}), 0.4), 0) << "not twice";
  while (grid.State(v) == VoxelState::kOccupied) {
    Miss(&grid, v);
  }
  EXPECT_FALSE(grid.Covered(v));
  while (grid.State(v) == VoxelState::kFree) {
    Hit(&grid, v);
  }
  EXPECT_TRUE(grid.Covered(v)) << "the probe was there, and what is around is not known";
  ExpectCountsAreTrue(grid);
}

TEST(VoxelGrid, ASurfaceFoundWhereTheProbeLookedAlreadyIsCovered) {
  VoxelGrid grid(test::Box(8));
  const VoxelIndex v{1, 2, 3};
  for (int z = 0; z <= 3; ++z) {
    while (grid.State({1, 2, z}) != VoxelState::kFree) {
      Miss(&grid, {1, 2, z});
    }
  }
  EXPECT_EQ(grid.MarkCovered(grid.Center({1, 2, 0}), 0.4), 1) << "z = 4, where the misses ended";
  EXPECT_FALSE(grid.Covered(v));
  while (grid.State(v) == VoxelState::kFree) {
    Hit(&grid, v);
  }
  EXPECT_TRUE(grid.Covered(v));
  ExpectCountsAreTrue(grid);
}

TEST(VoxelGrid, CoversAVoxelOfWhichOnlyAFaceIsInSight) {
  // From P beside a wall, its second voxel's centre is hidden by the first's corner.
  VoxelGrid grid(test::Box(12));
  for (const VoxelIndex& v : {VoxelIndex{4, 4, 0}, VoxelIndex{4, 5, 0}}) {
    Hit(&grid, v);
  }
  EXPECT_EQ(grid.MarkCovered(grid.Center({3, 0, 0}), 0.4), 2);
}

TEST(VoxelGrid, AVoxelHitTwiceStaysAnObstacleWhenLaterRaysPassIt) {
  VoxelGrid grid(test::Box(8));
  const VoxelIndex once{1, 1, 1};
  const VoxelIndex twice{5, 5, 5};
  Hit(&grid, once);
  Hit(&grid, twice);
  Hit(&grid, twice);
  for (const VoxelIndex& v : {once, twice}) {
    EXPECT_TRUE(grid.Obstacle(v));
    while (grid.State(v) == VoxelState::kOccupied) {
      Miss(&grid, v);
    }
  }
  EXPECT_FALSE(grid.Obstacle(once));
  EXPECT_TRUE(grid.Obstacle(twice));
}

TEST(VoxelGrid, CoversWhatIsNearAndInSight) {
  MapConfig config = test::Box(12);
  config.workspace_hi = {5, 11, 11};
  VoxelGrid grid(config);
  const VoxelIndex wall{3, 0, 0};
  const VoxelIndex behind{5, 0, 0};
  const VoxelIndex aside{3, 4, 0};
  const VoxelIndex far{0, 0, 9};
  const VoxelIndex outside_workspace{6, 3, 0};
  for (const VoxelIndex& v : {wall, behind, aside, far, outside_workspace}) {
    Hit(&grid, v);
  }
  EXPECT_EQ(grid.MarkCovered(grid.Center({0, 0, 0}), 0.4), 2);
  EXPECT_TRUE(grid.Covered(wall));
  EXPECT_TRUE(grid.Covered(aside));
  EXPECT_FALSE(grid.Covered(behind)) << "the wall hides it";
  EXPECT_FALSE(grid.Covered(far)) << "its centre is 0.45 m away";
  EXPECT_FALSE(grid.Covered(outside_workspace));
}

TEST(VoxelGrid, WhatTheRobotSweptIsNoObstacleUntilItIsHit) {
  VoxelGrid grid(test::Box(8));
  const Vector3d center = grid.Center({0, 0, 0});
  EXPECT_TRUE(grid.Obstacle({0, 0, 0}));
  grid.MarkSweptSphere(center, 0.06);
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    const double distance =
        ((grid.Center(v) - center).cwiseAbs().array() - 0.025).max(0.0).matrix().norm();
    EXPECT_EQ(grid.Swept(v), distance <= 0.06);
    EXPECT_EQ(grid.Obstacle(v), distance > 0.06);
    EXPECT_EQ(grid.State(v), VoxelState::kUnknown);
  }
  Hit(&grid, {0, 0, 0});
  EXPECT_FALSE(grid.Swept({0, 0, 0}));
  EXPECT_TRUE(grid.Obstacle({0, 0, 0}));
  Miss(&grid, {0, 1, -1});
  EXPECT_FALSE(grid.Obstacle({0, 1, -1}));
  grid.MarkSweptSphere(center, 0.06);
  EXPECT_TRUE(grid.Obstacle({0, 0, 0})) << "what is known stays as it is";
}

TEST(VoxelGrid, OnlyTheUnknownIsResidual) {
  VoxelGrid grid(test::Box(8));
  grid.SetResidual({1, 1, 1}, true);
  grid.SetResidual({1, 1, 1}, true);
  EXPECT_TRUE(grid.Residual({1, 1, 1}));
  EXPECT_EQ(grid.counts().residual, 1);
  Hit(&grid, {1, 1, 1});
  EXPECT_FALSE(grid.Residual({1, 1, 1}));
  EXPECT_FALSE(grid.Covered({1, 1, 1}));
  grid.SetResidual({1, 1, 1}, true);
  EXPECT_FALSE(grid.Residual({1, 1, 1}));
  EXPECT_EQ(grid.counts().residual, 0);
  grid.SetResidual({100, 0, 0}, true);  // outside: nothing happens
  ExpectCountsAreTrue(grid);
}

TEST(VoxelGrid, RevisionFollowsStatesAndSweeps) {
  VoxelGrid grid(test::Box(8));
  std::uint64_t last = grid.revision();
  const auto changed = [&] { return std::exchange(last, grid.revision()) != grid.revision(); };
  Hit(&grid, {1, 1, 1});
  EXPECT_TRUE(changed());
  Hit(&grid, {1, 1, 1});
  EXPECT_FALSE(changed()) << "occupied before and after";
  grid.MarkSweptSphere({0, 0, 0}, 0.01);
  EXPECT_TRUE(changed());
  grid.MarkSweptSphere({0, 0, 0}, 0.01);
  EXPECT_FALSE(changed());
}

TEST(VoxelGrid, OutsideTheBoxIsUnknownAndFreeToMoveUnlessConfigured) {
  MapConfig config = test::Box(4);
  const VoxelGrid open(config);
  EXPECT_EQ(open.State({4, 0, 0}), VoxelState::kUnknown);
  EXPECT_EQ(open.LogOdds({4, 0, 0}), 0);
  EXPECT_FALSE(open.Obstacle({4, 0, 0}));
  config.outside_is_obstacle = true;
  EXPECT_TRUE(VoxelGrid(config).Obstacle({4, 0, 0}));
}

TEST(VoxelGrid, IndicesRoundTrip) {
  MapConfig config;
  config.lo = config.workspace_lo = {-3, 5, -20};
  config.hi = config.workspace_hi = {4, 9, -7};
  const VoxelGrid grid(config);
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    ASSERT_TRUE(grid.InBox(v));
    ASSERT_EQ(grid.IndexOf(v), i);
    ASSERT_EQ(grid.VoxelOf(grid.Center(v)), v);
  }
  EXPECT_FALSE(grid.InBox(grid.VoxelOf({std::nan(""), 1e300, -1e300})));
}

TEST(VoxelGrid, ABoxInMetresBecomesWholeVoxels) {
  const VoxelBox exact = BoxOf({0, 0, -0.1}, {1.5, 1.5, 1.5}, 0.05);
  EXPECT_EQ(exact.lo, (VoxelIndex{0, 0, -2}));
  EXPECT_EQ(exact.hi, (VoxelIndex{29, 29, 29}));
  const VoxelBox grown = BoxOf({0.01, 0, 0}, {0.02, 0.051, 0.1}, 0.05, 2);
  EXPECT_EQ(grown.lo, (VoxelIndex{-2, -2, -2}));
  EXPECT_EQ(grown.hi, (VoxelIndex{2, 3, 3}));
}

TEST(MapConfig, ValidRefusesWhatCannotWork) {
  EXPECT_TRUE(Valid(MapConfig{}));
  const auto broken = [](auto&& change) {
    MapConfig config;
    change(config);
    return !Valid(config);
  };
  EXPECT_TRUE(broken([](MapConfig& c) { c.hi.x = -1; }));
  EXPECT_TRUE(broken([](MapConfig& c) { c.workspace_hi.y = 30; }));
  EXPECT_TRUE(broken([](MapConfig& c) { c.lo.z = -40000; }));
  EXPECT_TRUE(broken([](MapConfig& c) { c.width_m = 0; }));
  EXPECT_TRUE(broken([](MapConfig& c) { c.brick_capacity = 0; }));
  EXPECT_TRUE(broken([](MapConfig& c) { c.p_hit = 0.4; }));
  EXPECT_TRUE(broken([](MapConfig& c) { c.p_max = 1; }));
  EXPECT_TRUE(broken([](MapConfig& c) { c.field_range_m = 2; }));
}

TEST(VoxelGrid, SaysWhatItsMemoryIs) {
  const VoxelGrid grid(test::Box(16));
  EXPECT_LE(VoxelGrid::kBytesPerVoxel, 4.6);
  EXPECT_GE(static_cast<double>(grid.MemoryBytes()),
            grid.voxel_count() * VoxelGrid::kBytesPerVoxel);
  EXPECT_LE(static_cast<double>(grid.MemoryBytes()),
            grid.voxel_count() * VoxelGrid::kBytesPerVoxel + 4 * grid.voxel_count() + 50000);
}

}  // namespace
}  // namespace pipewright
