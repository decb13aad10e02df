// SPDX-License-Identifier: MIT
#include "perception/octomap/octomap_file.h"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <filesystem>
#include <fstream>

#include "platform/core/rng.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

std::string Temporary(const char* name) {
  return (std::filesystem::path(testing::TempDir()) / name).string();
}

VoxelGrid SomeMap(const MapConfig& config) {
  VoxelGrid grid(config);
  Rng rng(3);
  for (int s = 0; s < 3; ++s) {
    test::Scan scan;
    scan.origin_W = Vector3f(0.1F * static_cast<float>(s), 0.02F, -0.04F);
    for (int i = 0; i < 2000; ++i) {
      scan.points_W.emplace_back(
          scan.origin_W +
          Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized().cast<float>() * 0.7F);
    }
    test::InsertOurs(&grid, scan);
  }
  return grid;
}

TEST(OctomapFile, OtBringsEveryVoxelBackWithItsLogOdds) {
  const MapConfig config = test::Box(18);
  const VoxelGrid grid = SomeMap(config);
  const std::string path = Temporary("map.ot");
  ASSERT_EQ(WriteOt(grid, path), Status::kOk);
  VoxelGrid back(config);
  const Result<OctomapFileStats> read = ReadOctomap(path, &back);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->restored, grid.counts().free + grid.counts().occupied);
  EXPECT_EQ(read->outside, 0);
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    ASSERT_EQ(back.State(v), grid.State(v));
    ASSERT_EQ(back.LogOdds(v), grid.LogOdds(v));
  }
  EXPECT_EQ(back.visual_entropy(), grid.visual_entropy());
}

TEST(OctomapFile, BtBringsEveryStateBack) {
  const MapConfig config = test::Box(18);
  const VoxelGrid grid = SomeMap(config);
  const std::string path = Temporary("map.bt");
  ASSERT_EQ(WriteBt(grid, path), Status::kOk);
  VoxelGrid back(config);
  ASSERT_TRUE(ReadOctomap(path, &back).ok());
  for (int i = 0; i < grid.voxel_count(); ++i) {
    ASSERT_EQ(back.State(grid.VoxelAt(i)), grid.State(grid.VoxelAt(i)));
  }
  EXPECT_EQ(back.counts().occupied, grid.counts().occupied);
}

TEST(OctomapFile, LiboctomapReadsWhatWeWrite) {
  const VoxelGrid grid = SomeMap(test::Box(18));
  const std::string path = Temporary("theirs.bt");
  ASSERT_EQ(WriteBt(grid, path), Status::kOk);
  octomap::OcTree tree(path);
  EXPECT_DOUBLE_EQ(tree.getResolution(), 0.05);
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    const octomap::OcTreeNode* node = tree.search(test::KeyOf(v));
    ASSERT_EQ(node != nullptr, grid.KnownAt(i));
    ASSERT_EQ(node != nullptr && tree.isNodeOccupied(node), grid.OccupiedAt(i));
  }
}

TEST(OctomapFile, CountsWhatLiesOutsideTheBox) {
  const VoxelGrid grid = SomeMap(test::Box(18));
  const std::string path = Temporary("outside.ot");
  ASSERT_EQ(WriteOt(grid, path), Status::kOk);
  VoxelGrid small(test::Box(5));
  const Result<OctomapFileStats> read = ReadOctomap(path, &small);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->restored + read->outside, grid.counts().free + grid.counts().occupied);
  EXPECT_GT(read->outside, 0);
  EXPECT_EQ(small.State({0, 0, 0}), grid.State({0, 0, 0}));
}

TEST(OctomapFile, SaysWhatIsWrong) {
  const VoxelGrid grid = SomeMap(test::Box(4));
  EXPECT_EQ(WriteOt(grid, "/nowhere/at/all.ot"), Status::kUnavailable);
  EXPECT_EQ(WriteBt(grid, "/nowhere/at/all.bt"), Status::kUnavailable);
  VoxelGrid back(test::Box(4));
  EXPECT_EQ(ReadOctomap("/nowhere/at/all.ot", &back).status(), Status::kUnavailable);

  const std::string path = Temporary("not_a_map.ot");
  std::ofstream(path) << "# something else\n1 2 3\n";
  EXPECT_EQ(ReadOctomap(path, &back).status(), Status::kMalformed);

  const std::string coarse = Temporary("coarse.bt");
  octomap::OcTree tree(0.1);
  tree.updateNode(octomap::point3d(0, 0, 0), true);
  ASSERT_TRUE(tree.writeBinary(coarse));
  EXPECT_EQ(ReadOctomap(coarse, &back).status(), Status::kMalformed);
  EXPECT_EQ(back.counts().unknown, back.counts().total);
}

}  // namespace
}  // namespace pipewright
