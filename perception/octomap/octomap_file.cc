// SPDX-License-Identifier: MIT
#include "perception/octomap/octomap_file.h"

#include <octomap/octomap.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "perception/octomap/octree_bytes.h"

namespace pipewright {
namespace {

constexpr int kKeyOrigin = 32768;

octomap::OcTree TreeOf(const VoxelGrid& grid) {
  const MapConfig& c = grid.config();
  octomap::OcTree tree(c.width_m);
  tree.setProbHit(c.p_hit);
  tree.setProbMiss(c.p_miss);
  tree.setClampingThresMin(c.p_min);
  tree.setClampingThresMax(c.p_max);
  tree.setOccupancyThres(c.p_occupied);
  const auto key = [](int i) { return static_cast<octomap::key_type>(i + kKeyOrigin); };
  for (int i = 0; i < grid.voxel_count(); ++i) {
    if (grid.KnownAt(i)) {
      const VoxelIndex v = grid.VoxelAt(i);
      tree.setNodeValue(octomap::OcTreeKey(key(v.x), key(v.y), key(v.z)), grid.LogOdds(v), true);
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

/// The voxels of a leaf that are in the grid's box, and those that are not.
void RestoreLeaf(const OctreeLeaf& leaf, VoxelGrid& grid, OctomapFileStats& stats) {
  const MapConfig& box = grid.config();
  const int past = leaf.voxels - 1;
  const VoxelIndex lo{std::max(leaf.lo.x, box.lo.x), std::max(leaf.lo.y, box.lo.y),
                      std::max(leaf.lo.z, box.lo.z)};
  const VoxelIndex hi{std::min(leaf.lo.x + past, box.hi.x), std::min(leaf.lo.y + past, box.hi.y),
                      std::min(leaf.lo.z + past, box.hi.z)};
  stats.outside += std::int64_t{leaf.voxels} * leaf.voxels * leaf.voxels;
  VoxelIndex v;
  for (v.z = lo.z; v.z <= hi.z; ++v.z) {
    for (v.y = lo.y; v.y <= hi.y; ++v.y) {
      for (v.x = lo.x; v.x <= hi.x; ++v.x) {
        --stats.outside;
        ++(grid.Restore(v, leaf.log_odds) ? stats.restored : stats.refused);
      }
    }
  }
}

}  // namespace

Status WriteOt(const VoxelGrid& grid, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  return out && TreeOf(grid).write(out) && out.flush() ? Status::kOk : Status::kUnavailable;
}

Status WriteBt(const VoxelGrid& grid, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  return out && TreeOf(grid).writeBinary(out) && out.flush() ? Status::kOk : Status::kUnavailable;
}

Result<OctomapFileStats> ReadOctomap(const std::string& path, VoxelGrid* grid) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return Status::kUnavailable;
  }
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const Result<OctreeHead> head = ReadOctreeHead(bytes);
  const double width_m = grid->config().width_m;
  if (!head.ok() || std::abs(head->width_m - width_m) > 1e-9 * width_m ||
      ReadOctreeLeaves(bytes, *head, [](const OctreeLeaf&) {}) != Status::kOk) {
    return Status::kMalformed;  // before the grid is touched
  }
  OctomapFileStats stats;
  return ReadOctreeLeaves(bytes, *head,
                          [&](const OctreeLeaf& leaf) { RestoreLeaf(leaf, *grid, stats); }) ==
                 Status::kOk
             ? Result<OctomapFileStats>(stats)
             : Status::kMalformed;
}

}  // namespace pipewright
