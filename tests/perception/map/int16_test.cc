// SPDX-License-Identifier: MIT
// The build with log-odds of two bytes: OctoMap's states, and its log-odds to what a unit allows.
#include <gtest/gtest.h>

#include <cmath>

#include "platform/core/rng.h"
#include "tests/perception/map/map_data.h"

namespace pipewright {
namespace {

using test::Scan;

// How many states differ from OctoMap's, and by how much log-odds do at most.
struct Deviation {
  int states = 0;
  float log_odds = 0;
};

Deviation From(const octomap::OcTree& tree, const VoxelGrid& grid) {
  Deviation worst;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    const octomap::OcTreeNode* node = tree.search(test::KeyOf(v));
    const VoxelState theirs = node == nullptr             ? VoxelState::kUnknown
                              : tree.isNodeOccupied(node) ? VoxelState::kOccupied
                                                          : VoxelState::kFree;
    worst.states += grid.State(v) != theirs ? 1 : 0;
    if (node != nullptr) {
      worst.log_odds = std::max(worst.log_odds, std::abs(grid.LogOdds(v) - node->getLogOdds()));
    }
  }
  return worst;
}

TEST(Int16Map, TakesLittleMoreThanHalfTheMemory) { EXPECT_LE(VoxelGrid::kBytesPerVoxel, 2.6); }

TEST(Int16Map, HasOctomapsStates) {
  constexpr int kScans = 12;
  Rng rng(41);
  VoxelGrid grid(test::Box(14));
  octomap::OcTree tree(0.05);
  for (int s = 0; s < kScans; ++s) {
    Scan scan;
    for (int i = 0; i < 3; ++i) {
      scan.origin_W[i] = static_cast<float>(rng.Uniform(-0.2, 0.2));
    }
    for (int n = 0; n < 800; ++n) {
      const Vector3d d = Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
      scan.points_W.emplace_back((d * rng.Uniform(0.4, 0.6)).cast<float>());
    }
    test::InsertOurs(&grid, scan);
    test::InsertOctomap(&tree, scan);
  }
  const Deviation worst = From(tree, grid);
  EXPECT_LE(worst.log_odds, (kScans + 1) * 0.5F * kLogOddsUnit);
  EXPECT_EQ(worst.states, 0);
  EXPECT_GT(grid.counts().free, 3000);
  EXPECT_GT(grid.counts().occupied, 1000);
}

TEST(Int16Map, KeepsWhatIsRestoredWithinItsClamps) {
  VoxelGrid grid(test::Box(4));
  EXPECT_TRUE(grid.Restore({0, 0, 0}, 1e9F));
  EXPECT_TRUE(grid.Restore({1, 0, 0}, -1e9F));
  EXPECT_TRUE(grid.Restore({2, 0, 0}, 0.5F));
  EXPECT_NEAR(grid.LogOdds({0, 0, 0}), std::log(0.971 / 0.029), kLogOddsUnit);
  EXPECT_NEAR(grid.LogOdds({1, 0, 0}), std::log(0.1192 / 0.8808), kLogOddsUnit);
  EXPECT_EQ(grid.LogOdds({2, 0, 0}), 0.5F);
}

TEST(Int16Map, FlipsNoStateOfTheSharedSets) {
  const std::string folder = test::SharedMapFolder();
  if (folder.empty()) {
    GTEST_SKIP() << "SKIPPED: PIPEWRIGHT_SHARED is not set, the shared clouds were NOT checked";
  }
  for (const std::string scene : {"cube", "office"}) {
    SCOPED_TRACE(scene);
    VoxelGrid grid(test::WorkloadBox(scene));
    octomap::OcTree tree(0.05);
    for (const Scan& scan : test::ReadClouds(folder + scene + "_clouds.bin")) {
      test::InsertOurs(&grid, scan);
      test::InsertOctomap(&tree, scan);
    }
    EXPECT_EQ(From(tree, grid).states, 0);
  }
}

}  // namespace
}  // namespace pipewright
