// SPDX-License-Identifier: MIT
#include "perception/octomap/octomap_file.h"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

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

/// A file with this head and these nodes.
std::string Octree(bool binary, std::uint64_t size, const std::string& nodes) {
  return std::string("# Octomap OcTree ") + (binary ? "binary file" : "file") +
         "\n# a comment\n#\nid OcTree\nsize " + std::to_string(size) + "\nres 0.05\ndata\n" + nodes;
}

/// An .ot's node.
std::string Node(float log_odds, unsigned children) {
  std::string node(sizeof log_odds, '\0');
  std::memcpy(node.data(), &log_odds, sizeof log_odds);
  return node + static_cast<char>(children);
}

Result<OctomapFileStats> ReadBytes(const std::string& bytes, VoxelGrid& grid) {
  const std::string path = Temporary("bytes.ot");
  std::ofstream(path, std::ios::binary) << bytes;
  return ReadOctomap(path, &grid);
}

TEST(OctomapFile, ReadsALeafThatStandsForMoreThanAllOfTheBox) {
  // liboctomap would make a node of each of its 2^48 voxels.
  VoxelGrid grid(test::Box(4));
  const auto whole = ReadBytes(Octree(false, 1, Node(0.5F, 0)), grid);
  ASSERT_TRUE(whole.ok());
  EXPECT_EQ(whole->restored, grid.counts().total);
  EXPECT_EQ(whole->restored + whole->outside, std::int64_t{1} << 48);
  EXPECT_EQ(grid.counts().occupied, grid.counts().total);

  VoxelGrid half(test::Box(4));  // x at or above 0 free, below it unknown
  const auto binary = ReadBytes(Octree(true, 5, std::string("\x44\x44", 2)), half);
  ASSERT_TRUE(binary.ok());
  for (int i = 0; i < half.voxel_count(); ++i) {
    const VoxelIndex v = half.VoxelAt(i);
    ASSERT_EQ(half.State(v), v.x >= 0 ? VoxelState::kFree : VoxelState::kUnknown);
  }
  EXPECT_EQ(binary->restored, half.counts().free);
}

TEST(OctomapFile, RefusesWhatMakesNoSenseAndLeavesTheGridAsItIs) {
  std::string deep;  // 17 levels: one below a voxel
  for (int i = 0; i < 17; ++i) {
    deep += Node(0, 1);
  }
  std::string binary_deep;  // the same of a .bt: 16 nodes to a voxel, and one below it
  for (int i = 0; i < 16; ++i) {
    binary_deep += std::string("\x03\x00", 2);
  }
  const std::string endless(200'000, '\xFF');  // each node has eight that have eight
  const struct {
    const char* what;
    std::string bytes;
  } cases[] = {
      {"cut within a node", Octree(false, 2, Node(0, 1) + Node(1, 0).substr(0, 3))},
      {"deeper than a voxel", Octree(false, 18, deep + Node(1, 0))},
      {"deeper than a voxel, .bt", Octree(true, 18, binary_deep + std::string("\x01\x00", 2))},
      {"ever deeper, .bt", Octree(true, 100'001, endless)},
      {"more nodes than it says", Octree(false, 1, Node(0, 1) + Node(1, 0))},
      {"fewer nodes than it says", Octree(false, 3, Node(0, 1) + Node(1, 0))},
      {"bytes behind the nodes", Octree(false, 1, Node(1, 0) + "x")},
      {"no head", ""},
      {"half a head", Octree(false, 1, "").substr(0, 40)},
      {"another tree",
       "# Octomap OcTree file\nid ColorOcTree\nsize 1\nres 0.05\ndata\n" + Node(1, 0)},
      {"no size", "# Octomap OcTree file\nid OcTree\nres 0.05\ndata\n" + Node(1, 0)},
      {"a size that is no number", "# Octomap OcTree file\nid OcTree\nsize -1\nres 0.05\ndata\n"},
      {"a width that is no number", "# Octomap OcTree file\nid OcTree\nsize 0\nres nan\ndata\n"},
  };
  VoxelGrid grid(test::Box(4));
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    EXPECT_EQ(ReadBytes(c.bytes, grid).status(), Status::kMalformed);
    EXPECT_EQ(grid.counts().unknown, grid.counts().total);
  }
}

TEST(OctomapFile, CountsLogOddsThatAreNoNumbers) {
  VoxelGrid grid(test::Box(4));
  const auto read =
      ReadBytes(Octree(false, 1, Node(std::numeric_limits<float>::quiet_NaN(), 0)), grid);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->restored, 0);
  EXPECT_EQ(read->refused, grid.counts().total);
  EXPECT_EQ(grid.counts().unknown, grid.counts().total);
}

TEST(OctomapFile, ReadsWhatLiboctomapPrunes) {
  const MapConfig config = test::Box(12);
  octomap::OcTree tree(0.05);
  Rng rng(9);
  for (int x = -12; x < 12; ++x) {  // blocks of one kind, and single voxels
    for (int y = -12; y < 12; ++y) {
      for (int z = -12; z < 12; ++z) {
        const bool hit = (x >= 0) != (y < 4) || rng.Uniform() < 0.02;
        tree.updateNode(test::KeyOf({x, y, z}), hit, true);
      }
    }
  }
  tree.toMaxLikelihood();
  tree.updateInnerOccupancy();
  tree.prune();
  ASSERT_TRUE(tree.write(Temporary("pruned.ot")) && tree.writeBinary(Temporary("pruned.bt")));
  for (const char* name : {"pruned.ot", "pruned.bt"}) {
    VoxelGrid grid(config);
    ASSERT_TRUE(ReadOctomap(Temporary(name), &grid).ok());
    EXPECT_EQ(test::Difference(grid, tree), "") << name;
  }
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
