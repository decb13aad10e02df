// SPDX-License-Identifier: MIT
// What of the probe's marks outlasts a surface, and what does not.
#include <gtest/gtest.h>

#include <vector>

#include "platform/core/rng.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

constexpr float kOccupied = 1;  // log-odds
constexpr float kFree = -0.1F;  // however little

std::vector<VoxelIndex> Around(const VoxelIndex& v) {
  std::vector<VoxelIndex> around;
  for (int i = 0; i < 27; ++i) {
    if (i != 13) {
      around.push_back({v.x + i % 3 - 1, v.y + i / 3 % 3 - 1, v.z + i / 9 - 1});
    }
  }
  return around;
}

bool InTheOpen(const VoxelGrid& grid, const VoxelIndex& v) {
  bool free = grid.State(v) == VoxelState::kFree;
  for (const VoxelIndex& beside : Around(v)) {
    free = free && grid.InBox(beside) && grid.State(beside) == VoxelState::kFree;
  }
  return free;
}

/// All free but one voxel, which is occupied and covered.
class Marks : public testing::Test {
 protected:
  Marks() {
    for (int i = 0; i < grid_.voxel_count(); ++i) {
      grid_.Restore(grid_.VoxelAt(i), kFree);
    }
    grid_.Restore(v_, kOccupied);
    Probe();
  }

  void Probe() { grid_.MarkCovered(grid_.Center(v_), 0.01); }  // that voxel alone

  const VoxelIndex v_{0, -1, 0};  // in a corner of its brick
  VoxelGrid grid_{test::Box(6)};
};

TEST_F(Marks, WhatAppearsInTheOpenIsNotCoveredUntilItIsProbed) {
  EXPECT_TRUE(grid_.Covered(v_));
  grid_.Restore(v_, kFree);
  grid_.Restore(v_, kOccupied);
  EXPECT_FALSE(grid_.Covered(v_)) << "another thing, where the first was taken away";
  EXPECT_EQ(grid_.counts().covered, 0);
  Probe();
  EXPECT_TRUE(grid_.Covered(v_));
  grid_.Restore(v_, kFree);
  Probe();
  grid_.Restore(v_, kOccupied);
  EXPECT_FALSE(grid_.Covered(v_)) << "nothing was there when the probe passed";
}

TEST_F(Marks, OneVoxelAroundThatIsNotFreeKeepsWhatWasProbedUntilItIsFreeToo) {
  for (const VoxelIndex& beside : Around(v_)) {
    SCOPED_TRACE(testing::Message() << beside.x << " " << beside.y << " " << beside.z);
    grid_.Restore(beside, kOccupied);
    Probe();
    ASSERT_TRUE(grid_.Covered(v_));
    grid_.Restore(v_, kFree);
    grid_.Restore(v_, kOccupied);
    EXPECT_TRUE(grid_.Covered(v_)) << "a surface of both that comes and goes in one";
    grid_.Restore(v_, kFree);
    grid_.Restore(beside, kFree);
    grid_.Restore(v_, kOccupied);
    EXPECT_FALSE(grid_.Covered(v_)) << "both were gone";
  }
}

TEST_F(Marks, ASolidVoxelInTheOpenIsNoSurfaceThatIsLeft) {
  const int index = grid_.IndexOf(v_);
  grid_.Restore(v_, 3);
  grid_.Restore(v_, kFree);
  EXPECT_TRUE(grid_.Obstacle(v_));
  EXPECT_FALSE(grid_.SurfaceLeftAt(index));
  grid_.Restore({v_.x + 1, v_.y, v_.z}, kOccupied);
  EXPECT_TRUE(grid_.SurfaceLeftAt(index));
  Probe();
  EXPECT_FALSE(grid_.SurfaceLeftAt(index));
}

TEST(VoxelMarks, AtTheEdgeOfTheBoxNothingIsInTheOpen) {
  VoxelGrid grid(test::Box(2));
  for (int i = 0; i < grid.voxel_count(); ++i) {
    for (int k = 0; k < grid.voxel_count(); ++k) {
      grid.Restore(grid.VoxelAt(k), kFree);
    }
    const VoxelIndex v = grid.VoxelAt(i);
    grid.Restore(v, kOccupied);
    grid.MarkCovered(grid.Center(v), 0.01);
    grid.Restore(v, kFree);
    grid.Restore(v, kOccupied);
    EXPECT_EQ(grid.Covered(v), !Within(v, {-1, -1, -1}, {0, 0, 0}));
  }
}

TEST(VoxelMarks, AreForgottenInTheOpenAndNowhereElseThroughAnyHistory) {
  Rng rng(2);
  VoxelGrid grid(test::Box(6));
  const auto n = static_cast<std::size_t>(grid.voxel_count());
  std::vector<bool> gone(n);  // was in the open, and not probed since
  std::vector<bool> kept(
      n);  // was covered, and has had the same voxel at it that is not free since
  int new_ones = 0;
  int returned = 0;
  const auto somewhere = [&](double reach) {
    const double x = rng.Uniform(-reach, reach);
    const double y = rng.Uniform(-reach, reach);
    return Vector3d(x, y, rng.Uniform(-reach, reach));
  };
  for (int round = 0; round < 400; ++round) {
    const VoxelGrid before = grid;
    const Vector3f origin = somewhere(0.25).cast<float>();
    std::vector<Vector3f> points;
    for (int i = 0; i < 40; ++i) {
      points.emplace_back(somewhere(0.4).cast<float>());
    }
    grid.InsertScan(points.data(), 40, origin, -1);
    const auto stays = [&](const VoxelIndex& v) {
      return !grid.InBox(v) ||
             (before.State(v) != VoxelState::kFree && grid.State(v) != VoxelState::kFree);
    };
    for (int i = 0; i < grid.voxel_count(); ++i) {
      const VoxelIndex v = grid.VoxelAt(i);
      bool at_something = stays(v);
      for (const VoxelIndex& beside : Around(v)) {
        at_something = at_something || stays(beside);
      }
      gone[i] = gone[i] || InTheOpen(grid, v);
      kept[i] = kept[i] && at_something;
      const bool turned_occupied = before.State(v) == VoxelState::kFree && grid.OccupiedAt(i);
      if (turned_occupied && gone[i]) {
        ++new_ones;
        ASSERT_FALSE(grid.Covered(v)) << "round " << round;
      }
      if (turned_occupied && kept[i]) {
        ++returned;
        ASSERT_TRUE(grid.Covered(v)) << "round " << round;
      }
    }
    if (round % 3 == 0) {
      grid.MarkCovered(somewhere(0.3), 0.3);
    }
    for (int i = 0; i < grid.voxel_count(); ++i) {
      gone[i] = gone[i] && (round % 3 != 0 || InTheOpen(grid, grid.VoxelAt(i)));
      kept[i] = kept[i] || grid.CoveredAt(i);
    }
  }
  EXPECT_GT(new_ones, 20);
  EXPECT_GT(returned, 20);
}

}  // namespace
}  // namespace pipewright
