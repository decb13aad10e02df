// SPDX-License-Identifier: MIT
// The box as a window that follows the robot, against a grid that holds the whole world.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "perception/map/distance_field.h"
#include "platform/core/rng.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

constexpr double kWidth = 0.05;

MapConfig Bricks(const VoxelIndex& lo, const VoxelIndex& hi) {
  MapConfig config;
  config.lo = config.workspace_lo = {8 * lo.x, 8 * lo.y, 8 * lo.z};
  config.hi = config.workspace_hi = {8 * hi.x + 7, 8 * hi.y + 7, 8 * hi.z + 7};
  config.brick_capacity = BricksOfBox(config);
  return config;
}

MapConfig Window() { return Bricks({-2, -2, -1}, {2, 1, 1}); }

/// What has left the window, by brick.
class Store {
 public:
  void Take(const BrickVoxels& brick) { bricks_[Key(brick.lo)] = brick; }
  const BrickVoxels* Find(const VoxelIndex& lo) const {
    const auto at = bricks_.find(Key(lo));
    return at == bricks_.end() ? nullptr : &at->second;
  }
  int size() const { return static_cast<int>(bricks_.size()); }

 private:
  using Index = std::array<int, 3>;
  static Index Key(const VoxelIndex& v) { return {v.x, v.y, v.z}; }
  std::map<Index, BrickVoxels> bricks_;
};

/// Bricks that entered, taken back from the store.
void Refill(const Store& store, const MapConfig& before, VoxelGrid* window) {
  for (int i = 0; i < window->block_count(); ++i) {
    const VoxelIndex lo = window->BlockBox(i).lo;
    const BrickVoxels* brick = Within(lo, before.lo, before.hi) ? nullptr : store.Find(lo);
    for (int k = 0; brick != nullptr && k < BrickVoxels::kVoxels; ++k) {
      if (brick->known[k]) {
        ASSERT_TRUE(
            window->Restore({lo.x + k % 8, lo.y + k / 8 % 8, lo.z + k / 64}, brick->log_odds[k]));
      }
    }
  }
}

std::vector<Vector3f> Readings(const Vector3d& origin_W, double range_m, Rng* rng) {
  std::vector<Vector3f> points(80);
  for (Vector3f& p : points) {
    const double x = rng->Normal();
    const double y = rng->Normal();
    const Vector3d d = Vector3d(x, y, rng->Normal()).normalized();
    p = (origin_W + d * rng->Uniform(0, 1.2 * range_m)).cast<float>();
  }
  return points;
}

void ExpectCountsAreTrue(const VoxelGrid& grid) {
  MapCounts n;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    n.free += grid.State(v) == VoxelState::kFree ? 1 : 0;
    n.occupied += grid.State(v) == VoxelState::kOccupied ? 1 : 0;
    n.residual += grid.Residual(v) ? 1 : 0;
    n.unknown += grid.State(v) == VoxelState::kUnknown && !grid.Residual(v) ? 1 : 0;
    n.covered += grid.Covered(v) ? 1 : 0;
  }
  EXPECT_EQ(grid.counts().total, grid.voxel_count());
  EXPECT_EQ(grid.counts().free, n.free);
  EXPECT_EQ(grid.counts().occupied, n.occupied);
  EXPECT_EQ(grid.counts().residual, n.residual);
  EXPECT_EQ(grid.counts().unknown, n.unknown);
  EXPECT_EQ(grid.counts().covered, n.covered);
}

TEST(VoxelWindow, WithWhatLeftItIsTheGridOfTheWholeWorld) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Rng rng(seed);
    VoxelGrid whole(Bricks({-6, -6, -6}, {6, 6, 6}));
    VoxelGrid window(Window());
    const std::int64_t memory = window.MemoryBytes();
    Store store;
    Vector3d p_W(0.2, 0, 0.2);
    for (int step = 0; step < 60; ++step) {
      for (int i = 0; i < 3; ++i) {
        p_W[i] = std::clamp(p_W[i] + rng.Uniform(-0.5, 0.5), -1.2, 1.2);
      }
      const MapConfig before = window.config();
      window.Move(window.BricksTo(p_W), [&](const BrickVoxels& brick) { store.Take(brick); });
      Refill(store, before, &window);
      // From P the window reaches half its size less half a brick: no ray may go farther.
      const double range_m = 0.35;
      const std::vector<Vector3f> points = Readings(p_W, range_m, &rng);
      const auto count = static_cast<int>(points.size());
      const Vector3f origin_W = p_W.cast<float>();
      window.InsertScan(points.data(), count, origin_W, range_m);
      whole.InsertScan(points.data(), count, origin_W, range_m);
      for (int i = 0; i < window.voxel_count(); ++i) {
        const VoxelIndex v = window.VoxelAt(i);
        ASSERT_EQ(window.State(v), whole.State(v)) << "seed " << seed << ", step " << step;
        ASSERT_EQ(window.LogOdds(v), whole.LogOdds(v)) << "seed " << seed << ", step " << step;
      }
    }
    for (int i = 0; i < whole.voxel_count(); ++i) {
      const VoxelIndex v = whole.VoxelAt(i);
      const BrickVoxels* brick = store.Find({v.x & ~7, v.y & ~7, v.z & ~7});
      const int k = BrickVoxels::IndexOf(v.x & 7, v.y & 7, v.z & 7);
      if (!window.InBox(v)) {
        ASSERT_EQ(whole.State(v) != VoxelState::kUnknown, brick != nullptr && brick->known[k]);
        ASSERT_EQ(whole.LogOdds(v), brick == nullptr ? 0 : brick->log_odds[k]);
      }
    }
    EXPECT_GT(store.size(), 30);
    EXPECT_EQ(window.MemoryBytes(), memory);
    EXPECT_EQ(window.updates_refused(), 0);
  }
}

TEST(VoxelWindow, KeepsAllMarksOfWhatStaysAndNothingOfWhatEnters) {
  Rng rng(5);
  VoxelGrid grid(Window());
  for (int step = 0; step < 40; ++step) {
    const Vector3d p_W = grid.Center(grid.VoxelAt(rng.Index(grid.voxel_count())));
    const std::vector<Vector3f> points = Readings(p_W, 0.6, &rng);
    grid.InsertScan(points.data(), static_cast<int>(points.size()), p_W.cast<float>(), 0.6);
    grid.MarkSweptSphere(p_W, 0.1);
    grid.MarkCovered(p_W, 0.3);
    for (int i = 0; i < 200; ++i) {
      grid.SetResidual(grid.VoxelAt(rng.Index(grid.voxel_count())), true);
    }
    const VoxelGrid before = grid;
    const VoxelIndex by{rng.Index(5) - 2, rng.Index(5) - 2, rng.Index(3) - 1};
    int left = 0;
    int covered = 0;
    grid.Move(by, [&](const BrickVoxels& brick) {
      ++left;
      for (int k = 0; k < BrickVoxels::kVoxels; ++k) {
        const VoxelIndex v{brick.lo.x + k % 8, brick.lo.y + k / 8 % 8, brick.lo.z + k / 64};
        EXPECT_EQ(brick.known[k], before.State(v) != VoxelState::kUnknown);
        EXPECT_EQ(brick.log_odds[k], before.LogOdds(v));
        covered += brick.probed[k] && before.State(v) == VoxelState::kOccupied ? 1 : 0;
      }
    });
    int stayed_covered = 0;
    for (int i = 0; i < grid.voxel_count(); ++i) {
      const VoxelIndex v = grid.VoxelAt(i);
      ASSERT_EQ(grid.State(v), before.State(v));
      ASSERT_EQ(grid.LogOdds(v), before.LogOdds(v));
      ASSERT_EQ(grid.Swept(v), before.Swept(v));
      ASSERT_EQ(grid.Covered(v), before.Covered(v));
      ASSERT_EQ(grid.Residual(v), before.Residual(v));
      ASSERT_EQ(grid.Obstacle(v), before.InBox(v) ? before.Obstacle(v) : true);
      stayed_covered += grid.Covered(v) ? 1 : 0;
    }
    EXPECT_EQ(grid.bricks_used(), before.bricks_used() - left);
    EXPECT_EQ(before.counts().covered, stayed_covered + covered);
    EXPECT_EQ(before.revision() != grid.revision(), true);
    ExpectCountsAreTrue(grid);
  }
}

TEST(VoxelWindow, WhatWasProbedAtItsEdgeIsForgottenWhenWhatEntersIsFreeAllAround) {
  VoxelGrid grid(Window());
  const VoxelIndex v{grid.config().hi.x, 0, 0};
  const auto set_all = [&](float log_odds) {
    for (int i = 0; i < grid.voxel_count(); ++i) {
      ASSERT_TRUE(grid.Restore(grid.VoxelAt(i), log_odds));
    }
  };
  set_all(-1);
  grid.MarkCovered(grid.Center(v), 0.01);
  grid.Move({3, 1, 0}, [](const BrickVoxels& brick) { EXPECT_TRUE(brick.probed.none()); });
  grid.Restore(v, 1);
  EXPECT_TRUE(grid.Covered(v)) << "beyond it all is unknown";
  set_all(-1);
  grid.Restore(v, 1);
  EXPECT_FALSE(grid.Covered(v));
  ExpectCountsAreTrue(grid);
}

TEST(VoxelWindow, BricksOfItsPastAreFreeForItsFuture) {
  MapConfig config = Window();
  config.brick_capacity = 4;
  VoxelGrid grid(config);
  int left = 0;
  for (int step = 0; step < 20; ++step) {
    const VoxelIndex& lo = grid.config().lo;
    for (int i = 0; i < 4; ++i) {
      EXPECT_TRUE(grid.Restore({lo.x + 8 * i, lo.y, lo.z}, 1));
    }
    EXPECT_FALSE(grid.Restore({lo.x, lo.y + 8, lo.z}, 1)) << "full";
    grid.Move({4, 0, 0}, [&](const BrickVoxels&) { ++left; });
  }
  EXPECT_EQ(left, 80);
  EXPECT_EQ(grid.bricks_used(), 0);
  EXPECT_EQ(grid.config().lo.x, config.lo.x + 20 * 32);
}

TEST(VoxelWindow, FollowsAPointToWithinHalfABrickAndNoFartherThanTheKeys) {
  VoxelGrid grid(Window());
  Rng rng(6);
  for (int n = 0; n < 200; ++n) {
    const Vector3d p_W(rng.Uniform(-40, 40), rng.Uniform(-40, 40), rng.Uniform(-40, 40));
    grid.Move(grid.BricksTo(p_W), [](const BrickVoxels&) {});
    const Vector3d middle_W = (grid.Center(grid.config().lo) + grid.Center(grid.config().hi)) / 2;
    EXPECT_LE((p_W - middle_W).cwiseAbs().maxCoeff(), 4 * kWidth + 1e-9);
    EXPECT_EQ(grid.BricksTo(p_W), VoxelIndex{});
  }
  for (const double far : {1e300, -1e300}) {
    grid.Move(grid.BricksTo({far, far, far}), [](const BrickVoxels&) {});
    EXPECT_TRUE(Valid(grid.config()));
  }
  EXPECT_EQ(grid.BricksTo({std::nan(""), 0, 0}), VoxelIndex{});
}

TEST(VoxelWindow, DistanceFieldGoesAlong) {
  Rng rng(7);
  VoxelGrid grid(Window());
  DistanceField field(grid.config());
  for (int step = 0; step < 10; ++step) {
    const Vector3d p_W = grid.Center(grid.VoxelAt(rng.Index(grid.voxel_count())));
    grid.MarkSweptSphere(p_W, 0.4);
    field.Update(grid);
    grid.Move({rng.Index(3) - 1, rng.Index(3) - 1, rng.Index(3) - 1}, [](const BrickVoxels&) {});
    field.Update(grid);
    DistanceField anew(grid.config());
    anew.Update(grid);
    EXPECT_TRUE(field == anew);
    const Vector3d q_W = grid.Center(grid.VoxelAt(rng.Index(grid.voxel_count())));
    EXPECT_EQ(field.Distance(q_W), anew.Distance(q_W));
  }
}

TEST(VoxelWindow, OnlyABoxOfWholeBricksCanMove) {
  EXPECT_TRUE(WholeBricks(Window()));
  MapConfig config = Window();
  config.lo.x += 1;
  EXPECT_FALSE(WholeBricks(config));
  config = Window();
  config.hi.z -= 1;
  EXPECT_FALSE(WholeBricks(config));
}

}  // namespace
}  // namespace pipewright
